#include "grouser/vehicle/rig.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "grouser/terrain/parallel.h"
#include "grouser/vehicle/folder_lock.h"
#include "rig_case.h"

namespace grouser::vehicle {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

const Series& channel(const RigRow& r, const std::string& name) {
  if (name == "drawbar_pull") return r.drawbar_pull;
  if (name == "driving_torque") return r.driving_torque;
  if (name == "side_force") return r.side_force;
  if (name == "normal_force") return r.normal_force;
  return r.sinkage;
}

std::string text(double x) {
  char buf[40];
  std::snprintf(buf, sizeof buf, "%.9g", x);
  return std::isnan(x) ? "nan" : buf;
}
std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (char c : s) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::ofstream open_csv(const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::trunc);
  if (!out) throw ResultsError(file.string() + ": cannot be written; is the folder writable?");
  return out;
}

void write_sweep(const std::filesystem::path& file, const std::vector<RigRow>& rows) {
  std::ofstream out = open_csv(file);
  out << "slip,slip_definition,case,group,load_N,slip_symmetric,slip_rim,slip_angle_rad,angular_speed_rad_s,travel_"
         "speed_m_s";
  for (const RigChannel& c : rig_channels())
    out << ',' << c.name << '_' << c.csv_unit << ',' << c.name << "_sd_" << c.csv_unit;
  out << ",sinkage_profile_mm,sinkage_profile_sd_mm,stationary,simulated_s,touch_down_overshoot,drawbar_pull_model_error_N,"
         "driving_torque_model_error_Nm,sinkage_model_error_mm,outside,note\n";
  for (const RigRow& r : rows) {
    const RigCase& c = r.spec;
    const bool held = c.mode == RigCase::Mode::slip;
    out << text(held ? c.slip : r.slip_symmetric) << ',' << slip_definition_name(c.definition) << ',' << c.index << ','
        << quoted(c.group) << ',' << text(c.load) << ',' << text(r.slip_symmetric) << ',' << text(r.slip_rim) << ','
        << text(c.slip_angle) << ',' << text(r.angular_speed) << ',' << text(r.travel_speed);
    for (const RigChannel& ch : rig_channels()) {
      const Series& s = channel(r, ch.name);
      out << ',' << text(s.mean * ch.csv_scale) << ',' << text(s.sd * ch.csv_scale);
    }
    out << ',' << text(1e3 * r.sinkage_profile.mean) << ',' << text(1e3 * r.sinkage_profile.sd) << ','
        << (r.stationary ? 1 : 0) << ',' << text(r.simulated_s) << ',' << text(r.touch_down_overshoot) << ','
        << text(r.model_error[0]) << ',' << text(r.model_error[1]) << ',' << text(1e3 * r.model_error[2]) << ','
        << text(r.outside) << ',' << quoted(r.note) << '\n';
  }
}

void write_measured(const std::filesystem::path& file, const RigMeasured& m) {
  std::ofstream out = open_csv(file);
  out << "slip";
  for (const RigMeasuredChannel& c : m.channels) {
    const auto& info = *std::find_if(rig_channels().begin(), rig_channels().end(),
                                     [&](const RigChannel& k) { return c.name == k.name; });
    out << ',' << c.name << '_' << info.csv_unit;
    if (!c.error.empty()) out << ',' << c.name << "_error_" << info.csv_unit;
  }
  out << '\n';
  for (std::size_t i = 0; i < m.slip.size(); ++i) {
    out << text(m.slip[i]);
    for (const RigMeasuredChannel& c : m.channels) {
      const auto& info = *std::find_if(rig_channels().begin(), rig_channels().end(),
                                       [&](const RigChannel& k) { return c.name == k.name; });
      out << ',' << text(c.value[i] * info.csv_scale);
      if (!c.error.empty()) out << ',' << text(c.error[i] * info.csv_scale);
    }
    out << '\n';
  }
}

void write_errors(const std::filesystem::path& file, const std::vector<RigErrorRow>& errors) {
  std::ofstream out = open_csv(file);
  out << "group,channel,unit,points,rmse,bias,measured_range,rmse_over_range,reading_error\n";
  for (const RigErrorRow& e : errors)
    out << quoted(e.group) << ',' << e.channel << ',' << e.unit << ',' << e.points << ',' << text(e.rmse) << ','
        << text(e.bias) << ',' << text(e.measured_range) << ',' << text(e.rmse / e.measured_range) << ','
        << text(e.reading_error) << '\n';
}

/// Simulated value at a stated slip: linear between the cases of the group; NaN outside of them.
double at_slip(const std::vector<const RigRow*>& group, const std::string& name, double slip) {
  for (std::size_t i = 0; i < group.size(); ++i) {
    const double a = group[i]->spec.slip;
    if (std::abs(slip - a) < 1e-9) return channel(*group[i], name).mean;
    if (i + 1 == group.size()) break;
    const double b = group[i + 1]->spec.slip;
    if (slip > a && slip < b) {
      const double w = (slip - a) / (b - a);
      return (1 - w) * channel(*group[i], name).mean + w * channel(*group[i + 1], name).mean;
    }
  }
  return nan;
}

/// Errors per group and channel, in the units of the csv files.
std::vector<RigErrorRow> errors_of(const RigMeasured& m, const std::vector<RigRow>& rows) {
  std::vector<std::pair<std::string, std::vector<const RigRow*>>> groups;
  for (const RigRow& r : rows) {
    if (r.spec.mode != RigCase::Mode::slip) continue;
    if (groups.empty() || groups.back().first != r.spec.group) groups.push_back({r.spec.group, {}});
    groups.back().second.push_back(&r);
  }
  std::vector<RigErrorRow> out;
  for (auto& [name, group] : groups) {
    std::sort(group.begin(), group.end(), [](const RigRow* a, const RigRow* b) { return a->spec.slip < b->spec.slip; });
    for (const RigMeasuredChannel& c : m.channels) {
      const auto& info = *std::find_if(rig_channels().begin(), rig_channels().end(),
                                       [&](const RigChannel& k) { return c.name == k.name; });
      RigErrorRow e;
      e.group = name;
      e.channel = c.name;
      e.unit = info.csv_unit;
      double squares = 0, sum = 0, stated = 0, low = INFINITY, high = -INFINITY;
      for (std::size_t i = 0; i < c.value.size(); ++i) {
        const double simulated = at_slip(group, c.name, m.slip[i]);
        if (std::isnan(simulated)) continue;
        const double d = (simulated - c.value[i]) * info.csv_scale;
        squares += d * d;
        sum += d;
        stated += c.error.empty() ? nan : c.error[i] * info.csv_scale;
        low = std::min(low, c.value[i] * info.csv_scale);
        high = std::max(high, c.value[i] * info.csv_scale);
        ++e.points;
      }
      const double n = e.points;
      e.rmse = n > 0 ? std::sqrt(squares / n) : nan;
      e.bias = n > 0 ? sum / n : nan;
      e.measured_range = n > 0 ? high - low : nan;
      e.reading_error = n > 0 ? stated / n : nan;
      out.push_back(e);
    }
  }
  return out;
}

}  // namespace

void check_rig(const std::filesystem::path& yaml, const Registry& registry, const std::optional<std::string>& terrain,
               const std::vector<double>& slips) {
  load_rig(yaml, registry, terrain, slips);
}

RigSummary run_rig(const std::filesystem::path& yaml, const Registry& registry, const RigOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  const RigSpec spec = load_rig(yaml, registry, options.terrain, options.slips);
  if (options.integrator != "fixed" && options.integrator != "cvode")
    throw ConfigError("--integrator", 0, 0, "'" + options.integrator + "' is unknown; known: fixed, cvode");
  const bool cvode = options.integrator == "cvode";
  if (cvode && !spec.make_terrain(registry)->capabilities().continuous)
    throw ConfigError(
        yaml.string(), 0, 0,
        "terrain '" + spec.model +
            "' has no force law that an ODE solver can follow (it integrates inside); use --integrator fixed");

  RigSummary summary;
  summary.folder = options.out;
  summary.notices = spec.notices;
  summary.rows.resize(spec.cases.size());
  const FolderLock lock(options.out);
  // Left-overs of an earlier sweep would be read as cases of this one.
  for (const auto& entry : std::filesystem::directory_iterator(options.out))
    if (entry.path().filename().string().starts_with("case_")) std::filesystem::remove_all(entry.path());
  for (const char* old : {"sweep.csv", "errors.csv", "measured.csv"}) std::filesystem::remove(options.out / old);

  double total = 0, done = 0;
  for (const RigCase& c : spec.cases) total += HeldMotion(spec, c).end();
  FileLock files;
  std::mutex making, telling;  // the options' reader keeps notes while a model is built
  parallel_for(static_cast<int>(spec.cases.size()), options.threads, [&](int i) {
    const RigCase& c = spec.cases[static_cast<std::size_t>(i)];
    RigRow& row = summary.rows[static_cast<std::size_t>(i)];
    row.spec = c;
    char name[32];
    std::snprintf(name, sizeof name, "case_%03d", i);
    RigRecord record(spec, c, options.out / name, files);
    const CaseContext context{spec, c,
                              [&] {
                                const std::lock_guard guard(making);
                                return spec.make_bare_terrain(registry);
                              },
                              record,
                              [&](double simulated) {
                                const std::lock_guard guard(telling);
                                done += simulated;
                                if (options.progress) options.progress(done, total, seconds());
                              }};
    const double started = seconds();
    try {
      const std::string hash = cvode ? run_cvode(context, row) : run_fixed(context, row);
      row.wall_s = seconds() - started;
      record.finish(row, hash);
    } catch (const std::exception& e) {
      record.fail(e.what());
      const std::string where = case_name(c) + ": ";
      const std::string what = e.what();
      throw RigError(what.starts_with(where) ? what : where + what);
    }
  });
  write_sweep(options.out / "sweep.csv", summary.rows);
  if (spec.measured) {
    summary.errors = errors_of(*spec.measured, summary.rows);
    write_measured(options.out / "measured.csv", *spec.measured);
    write_errors(options.out / "errors.csv", summary.errors);
  }
  for (const RigRow& r : summary.rows) summary.simulated_s += r.simulated_s;
  summary.wall_s = seconds();
  return summary;
}

}  // namespace grouser::vehicle
