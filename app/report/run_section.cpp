#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <regex>

#include "grouser/terrain/recorder.h"
#include "section.h"
#include "welch.h"

namespace grouser::report {

using nlohmann::json;

namespace {

constexpr std::size_t most_plot_values = 4000;
constexpr double pose_rate = 60.0;  // [Hz] of the playback
constexpr std::size_t most_poses = 6000;
constexpr std::size_t most_ground_nodes = 250000;
constexpr std::size_t most_triangles = 60000;

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> out;
  std::string word;
  for (char c : list + ",") {
    if (c == ',') {
      if (!word.empty()) out.push_back(word);
      word.clear();
    } else if (c != ' ') {
      word += c;
    }
  }
  return out;
}

bool ends_with(const std::string& s, const std::string& tail) {
  return s.size() > tail.size() && s.compare(s.size() - tail.size(), tail.size(), tail) == 0;
}

/// Values at the thinned frames: all of them, or the least and the greatest of each bucket in the order in which they
/// came.
std::vector<double> thin(const std::vector<double>& x, std::size_t bucket) {
  if (bucket <= 1) return x;
  std::vector<double> out;
  for (std::size_t a = 0; a < x.size(); a += bucket) {
    const auto first = x.begin() + static_cast<std::ptrdiff_t>(a);
    const auto last = x.begin() + static_cast<std::ptrdiff_t>(std::min(a + bucket, x.size()));
    const auto [lo, hi] = std::minmax_element(first, last);
    out.push_back(lo <= hi ? *lo : *hi);
    out.push_back(lo <= hi ? *hi : *lo);
  }
  return out;
}

/// Two instants per bucket, at a quarter and three quarters of it.
std::vector<double> thin_time(const std::vector<double>& t, std::size_t bucket) {
  if (bucket <= 1) return t;
  std::vector<double> out;
  for (std::size_t a = 0; a < t.size(); a += bucket) {
    const std::size_t n = std::min(bucket, t.size() - a);
    const double span = t[a + n - 1] - t[a];
    out.push_back(t[a] + 0.25 * span);
    out.push_back(t[a] + 0.75 * span);
  }
  return out;
}

struct Statistics {
  double mean = 0, rms = 0, sd = 0, min = 0, max = 0;
  std::size_t missing = 0;
};

Statistics statistics(const std::vector<double>& x) {
  Statistics s;
  std::size_t n = 0;
  double square = 0;
  s.min = std::numeric_limits<double>::infinity();
  s.max = -s.min;
  for (double v : x) {
    if (!std::isfinite(v)) continue;
    ++n;
    s.mean += v;
    square += v * v;
    s.min = std::min(s.min, v);
    s.max = std::max(s.max, v);
  }
  s.missing = x.size() - n;
  if (n == 0) return {0, 0, 0, 0, 0, s.missing};
  const auto count = static_cast<double>(n);
  s.mean /= count;
  s.rms = std::sqrt(square / count);
  for (double v : x)
    if (std::isfinite(v)) s.sd += (v - s.mean) * (v - s.mean);
  s.sd = std::sqrt(s.sd / count);
  return s;
}

struct Reader {
  const RunFile& file;
  Pack& pack;
  std::vector<double> time;
  std::size_t bucket = 1, pose_stride = 1;
  json warnings = json::array();

  std::vector<double> scalar(const std::string& name) const {
    return file.has(name) ? file.read(name) : std::vector<double>{};
  }
  double last(const std::string& name) const {
    const auto x = scalar(name);
    return x.empty() ? std::numeric_limits<double>::quiet_NaN() : x.back();
  }
};

json number_or_null(double x) { return std::isfinite(x) ? json(x) : json(nullptr); }

/// Scalars go to the plots with their statistics, vectors to the playback.
void add_channels(Reader& r, json& out) {
  json channels = json::object(), stats = json::object();
  for (const ChannelSpec& c : r.file.channels()) {
    const auto x = r.file.read(c.name);
    json entry = {{"unit", c.unit}, {"description", c.description}};
    if (c.components == 1) {
      const Statistics s = statistics(x);
      stats[c.name] = {{"mean", s.mean}, {"rms", s.rms}, {"sd", s.sd}, {"min", s.min}, {"max", s.max}};
      if (s.missing > 0)
        r.warnings.push_back(c.name + ": " + std::to_string(s.missing) + " of " + std::to_string(x.size()) +
                             " values are missing");
      entry["data"] = r.pack.add(thin(x, r.bucket));
    } else {
      const auto width = static_cast<std::size_t>(c.components);
      const bool place = ends_with(c.name, ".position") || ends_with(c.name, ".contact_point");
      entry["components"] = json::array();
      for (std::size_t k = 0; k < width; ++k) {
        std::vector<double> part;
        for (std::size_t i = 0; i < r.time.size(); i += r.pose_stride) part.push_back(x[i * width + k]);
        entry["components"].push_back(place ? r.pack.add_fixed(part, 1e-5) : r.pack.add(part));
      }
    }
    channels[c.name] = std::move(entry);
  }
  out["channels"] = std::move(channels);
  out["statistics"] = std::move(stats);
}

void add_ground(Reader& r, json& out) {
  if (!r.file.has("ground.x") || !r.file.has("ground.y") || !r.file.has("ground.height")) return;
  const auto x = r.file.read("ground.x"), y = r.file.read("ground.y"), h = r.file.read("ground.height");
  if (x.size() < 2 || y.size() < 2 || h.size() != x.size() * y.size())
    throw ResultsError(out["folder"].get<std::string>() +
                       ": ground.height does not have the size of ground.y times ground.x");
  std::size_t stride = 1;
  while (((x.size() - 1) / stride + 1) * ((y.size() - 1) / stride + 1) > most_ground_nodes) ++stride;
  std::vector<double> gx, gy, gh;
  for (std::size_t i = 0; i < x.size(); i += stride) gx.push_back(x[i]);
  for (std::size_t j = 0; j < y.size(); j += stride) gy.push_back(y[j]);
  for (std::size_t j = 0; j < y.size(); j += stride)
    for (std::size_t i = 0; i < x.size(); i += stride) gh.push_back(h[j * x.size() + i]);
  out["ground_grid"] = {
      {"x", r.pack.add_fixed(gx, 1e-5)}, {"y", r.pack.add_fixed(gy, 1e-5)}, {"height", r.pack.add(gh)}};
}

void add_meshes(Reader& r, json& out) {
  json meshes = json::object();
  for (const std::string& b : out["bodies"].get<std::vector<std::string>>()) {
    const std::string head = "mesh." + b;
    if (!r.file.has(head + ".vertices") || !r.file.has(head + ".triangles")) continue;
    const auto v = r.file.read(head + ".vertices"), t = r.file.read(head + ".triangles");
    if (t.size() / 3 > most_triangles) {
      r.warnings.push_back(head + ": " + std::to_string(t.size() / 3) +
                           " triangles are too many for the page; the body is not drawn");
      continue;
    }
    meshes[b] = {{"vertices", r.pack.add(v)}, {"triangles", r.pack.add_fixed(t, 1.0)}};
  }
  out["meshes"] = std::move(meshes);
}

/// Sets "NAME.FRAME" with their times, by time.
std::vector<std::pair<double, std::string>> sets_of(const Reader& r, const std::string& name) {
  std::vector<std::pair<double, std::string>> sets;
  for (const ChannelSpec& s : r.file.statics())
    if (s.name.starts_with(name + ".") && !ends_with(s.name, ".time"))
      if (const auto t = r.scalar(s.name + ".time"); !t.empty()) sets.push_back({t.front(), s.name});
  std::sort(sets.begin(), sets.end());
  return sets;
}
constexpr std::size_t most_sets = 200;
std::size_t set_stride(std::size_t sets) { return (sets + most_sets - 1) / most_sets; }

/// Grains near the wheels, as they were every few frames.
void add_points(Reader& r, json& out) {
  const auto sets = sets_of(r, "points");
  if (sets.empty()) return;
  std::vector<double> time;
  json frames = json::array();
  for (std::size_t k = 0; k < sets.size(); k += set_stride(sets.size())) {
    const std::vector<double> x = r.file.read(sets[k].second);
    json frame = json::array();
    for (std::size_t c = 0; c < 4; ++c) {
      std::vector<double> part;
      for (std::size_t i = c; i < x.size(); i += 4) part.push_back(x[i]);
      frame.push_back(r.pack.add(part));
    }
    time.push_back(sets[k].first);
    frames.push_back(std::move(frame));
  }
  out["points"] = {{"time", r.pack.add_fixed(time, 1e-6)}, {"frames", std::move(frames)}};
}

/// Squares of the surface of grains that changed from set to set. Where sets are too many, some are joined: none may be
/// left out.
void add_surface(Reader& r, json& out) {
  const auto sets = sets_of(r, "surface");
  if (sets.empty()) return;
  const std::size_t stride = set_stride(sets.size());
  std::vector<double> time;
  json frames = json::array();
  double side = 0;
  for (std::size_t k = 0; k < sets.size(); k += stride) {
    std::map<std::pair<double, double>, double> rise;  // a square counts as it was last
    const std::size_t last = std::min(k + stride, sets.size()) - 1;
    for (std::size_t j = k; j <= last; ++j) {
      const std::vector<double> x = r.file.read(sets[j].second);
      for (std::size_t i = 0; i + 3 < x.size(); i += 4) {
        rise[{x[i], x[i + 1]}] = x[i + 3];
        side = x[i + 2];
      }
    }
    std::vector<double> x, y, z;
    for (const auto& [at, value] : rise) {
      x.push_back(at.first);
      y.push_back(at.second);
      z.push_back(value);
    }
    time.push_back(sets[last].first);
    frames.push_back({r.pack.add_fixed(x, 1e-5), r.pack.add_fixed(y, 1e-5), r.pack.add_fixed(z, 1e-5)});
  }
  out["surface"] = {{"time", r.pack.add_fixed(time, 1e-6)}, {"side", side}, {"frames", std::move(frames)}};
}

void add_spectrum(Reader& r, json& out) {
  const auto a = r.scalar("vehicle.vertical_acceleration");
  if (a.size() < 64) return;
  const double step = (r.time.back() - r.time.front()) / static_cast<double>(r.time.size() - 1);
  for (std::size_t i = 1; i < r.time.size(); ++i)
    if (!(std::abs(r.time[i] - r.time[i - 1] - step) < 0.01 * step)) {
      r.warnings.push_back("no spectrum of the vertical acceleration: the frames are not evenly spaced in time");
      return;
    }
  const Spectrum s = welch(a, 1.0 / step);
  if (s.density.empty()) return;
  json density = json::array();
  for (double d : s.density) density.push_back(static_cast<float>(d));
  out["spectrum"] = {{"resolution", s.resolution}, {"segments", s.segments}, {"density", std::move(density)}};
}

/// Residual against the run's own yardstick (VehicleEnergy::yardstick). A run that did not end has none yet: then the positive motor
/// work and the height energy given up are taken from the frames.
void add_energy(const Reader& r, json& s) {
  constexpr double nothing_done = 1e-3;  // [J] below it a percentage says nothing
  const double residual = r.last("energy.residual");
  const auto motor = r.scalar("energy.motor");
  double driven = motor.empty() ? 0 : std::max(0.0, motor.front()), fallen = -r.last("energy.potential");
  for (std::size_t i = 1; i < motor.size(); ++i) driven += std::max(0.0, motor[i] - motor[i - 1]);
  if (!(fallen > driven)) fallen = 0;
  const std::string name = r.file.attribute("energy_yardstick");
  const double yardstick = r.file.number("energy_yardstick_J", std::max(driven, fallen));
  s["energy_residual_J"] = number_or_null(residual);
  s["energy_yardstick_J"] = number_or_null(yardstick);
  s["energy_yardstick"] = !name.empty() ? name : fallen > 0 ? "height energy given up" : "positive motor work";
  s["energy_residual_ratio"] = number_or_null(
      yardstick >= nothing_done ? r.file.number("energy_residual_ratio", std::abs(residual) / yardstick) : NAN);
}

void add_summary(Reader& r, json& out) {
  json s = json::object();
  const double simulated = r.time.empty() ? 0.0 : r.time.back() - r.time.front();
  const double distance = r.last("vehicle.distance"), motor = r.last("vehicle.motor_energy"),
               battery = r.last("vehicle.battery_energy");
  s["simulated_s"] = r.file.number("simulated_s", simulated);
  s["distance_m"] = number_or_null(distance);
  s["mean_speed_mps"] = number_or_null(simulated > 0 ? distance / simulated : NAN);
  s["energy_per_metre"] = number_or_null(distance > 0 ? motor / distance : NAN);
  s["battery_per_metre"] = number_or_null(distance > 0 ? battery / distance : NAN);
  double sinkage = -std::numeric_limits<double>::infinity(), drift = 0;
  std::string deepest;
  for (const std::string& w : out["wheels"].get<std::vector<std::string>>())
    for (double z : r.scalar(w + ".sinkage"))
      if (z > sinkage) {
        sinkage = z;
        deepest = w;
      }
  s["max_sinkage_m"] = number_or_null(sinkage);
  s["deepest_wheel"] = deepest;
  for (double d : r.scalar("joint.drift")) drift = std::max(drift, std::abs(d));
  s["joint_drift_m"] = drift;
  add_energy(r, s);
  const double wall = r.file.number("timing.wall_s", NAN);
  s["real_time_factor"] = number_or_null(wall > 0 ? r.file.number("simulated_s", simulated) / wall : NAN);
  json timing = json::object();
  for (const char* part : {"bullet_s", "terrain_s", "output_s", "wall_s"})
    timing[part] = number_or_null(r.file.number(std::string("timing.") + part, NAN));
  s["timing"] = std::move(timing);
  out["summary"] = std::move(s);
}

void add_warnings(Reader& r, json& out) {
  const std::string status = out["status"];
  if (status == "running")
    r.warnings.push_back(
        "The run was still writing or was killed: this is what it had. 'grouser resume' continues it.");
  else if (!status.empty() && status != "finished")
    r.warnings.push_back("The run did not finish: " + status);
  if (r.time.empty()) r.warnings.push_back("The run has no frame yet");
  const json noted = json::parse(r.file.attribute("warnings"), nullptr, false);
  if (noted.is_array())
    for (const json& w : noted) r.warnings.push_back(w);
  const json& s = out["summary"];
  char text[160];
  if (s["energy_residual_ratio"].is_number() && s["energy_residual_ratio"].get<double>() > 0.005) {
    std::snprintf(text, sizeof text,
                  "The energy ledger does not close: residual %.3g J, %.2f %% of the %s (limit 0.5 %%)",
                  s["energy_residual_J"].is_number() ? s["energy_residual_J"].get<double>() : NAN,
                  100 * s["energy_residual_ratio"].get<double>(), s["energy_yardstick"].get<std::string>().c_str());
    r.warnings.push_back(text);
  }
  if (s["joint_drift_m"].get<double>() > 1e-4) {
    std::snprintf(text, sizeof text, "Joint drift %.3f mm is above 0.1 mm", 1e3 * s["joint_drift_m"].get<double>());
    r.warnings.push_back(text);
  }
}

/// The soil's name: an attribute, or the first `soil:` of the scenario text.
std::string soil_name(const RunFile& f) {
  if (std::string s = f.attribute("soil"); !s.empty()) return s;
  std::smatch m;
  const std::string& text = f.attributes().scenario;
  if (!std::regex_search(text, m, std::regex(R"((?:^|\n)[ \t]*soil:[ \t]*["']?([^"'#\n]+))"))) return "";
  std::string s = m[1];
  while (!s.empty() && (s.back() == ' ' || s.back() == '\r')) s.pop_back();
  // A path names its file.
  return s.ends_with(".yaml") ? std::filesystem::path(s).stem().string() : s;
}

}  // namespace

std::string folder_name(const std::filesystem::path& folder) {
  std::filesystem::path p = std::filesystem::absolute(folder).lexically_normal();
  if (!p.has_filename()) p = p.parent_path();
  return p.filename().string();
}

json run_section(const std::filesystem::path& folder, Pack& pack) {
  const RunFile file(folder / "run.h5");
  const RunAttributes& a = file.attributes();
  const std::string effects = file.attribute("effects");
  const std::string model = a.terrain + (effects.empty() ? "" : " with " + effects);
  json out = {{"folder", folder_name(folder)}, {"kind", a.kind}, {"title", a.title},       {"terrain", model},
              {"version", a.version},          {"seed", a.seed}, {"scenario", a.scenario}, {"soil", soil_name(file)}};
  for (const char* name : {"status", "ground", "end_state_hash"}) out[name] = file.attribute(name);
  for (const char* name : {"total_mass_kg", "gravity"}) out[name] = number_or_null(file.number(name, NAN));
  out["bodies"] = split(file.attribute("bodies"));
  out["wheels"] = split(file.attribute("wheels"));
  out["assumptions"] = json::parse(file.attribute("assumptions"), nullptr, false);
  if (!out["assumptions"].is_array()) out["assumptions"] = json::array();

  Reader r{file, pack, file.time(), 1, 1};
  const std::size_t n = r.time.size();
  if (n > most_plot_values) r.bucket = (2 * n + most_plot_values - 1) / most_plot_values;
  if (n > 1) {
    const double rate = static_cast<double>(n - 1) / (r.time.back() - r.time.front());
    r.pose_stride = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(rate / pose_rate - 1e-6)));
    while (n / r.pose_stride > most_poses) ++r.pose_stride;
    out["frame_rate"] = rate;
  }
  out["frames"] = n;
  out["thinned"] = r.bucket > 1;
  std::vector<double> pose_time;
  for (std::size_t i = 0; i < n; i += r.pose_stride) pose_time.push_back(r.time[i]);
  out["time"] = pack.add_fixed(thin_time(r.time, r.bucket), 1e-6);
  out["pose_time"] = pack.add_fixed(pose_time, 1e-6);

  add_channels(r, out);
  add_ground(r, out);
  add_meshes(r, out);
  add_points(r, out);
  add_surface(r, out);
  add_spectrum(r, out);
  add_summary(r, out);
  add_warnings(r, out);
  out["warnings"] = std::move(r.warnings);
  return out;
}

}  // namespace grouser::report
