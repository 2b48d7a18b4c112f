// Training plan from YAML; files of its runs.
#include "grouser/sdem/training.h"

#include <cmath>
#include <cstdio>

#include "compact_file.h"
#include "grouser/dem/packing.h"
#include "grouser/sdem/v1.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/state.h"

namespace grouser::sdem {

namespace fs = std::filesystem;

namespace {

constexpr const char* kKind = "sdem training run";

void put(std::string& text, const char* name, double value) {
  char line[80];
  std::snprintf(line, sizeof line, "%s %.17g\n", name, value);
  text += line;
}

TrainingRun read_run(const ConfigNode& n, const TrainingPlan& p) {
  TrainingRun r;
  r.seed = static_cast<int>(n.integer("seed", 0, 1000000));
  r.start = n.quantity_or("start", 0, "m", Range::between(-10, 10));
  r.ground = n.has("ground") ? load_ground(n.node("ground"), 0) : flat_ground();
  const int kinds = n.has("load") + n.has("depth") + n.has("press");
  if (kinds != 1) n.error("needs one of 'load', 'depth' and 'press'");
  if (n.has("press")) {
    r.kind = TrainingRun::Kind::press;
    r.press = n.quantities("press", "N", 0, Range::positive());
  } else {
    if (n.has("load")) r.load = n.quantity("load", "N", Range::positive());
    if (n.has("depth")) {
      r.kind = TrainingRun::Kind::held;
      r.depth = n.quantity("depth", "m", {-p.radius, p.radius, true, true});
      r.swing = n.quantity_or("swing", 0, "m", Range::between(0, p.radius));
      r.length = n.quantity_or("length", r.length, "m", Range::positive());
    }
    r.slips = n.quantities("slips", "1", 0, {-10, 1, true, true});
    r.distance = n.quantity("distance", "m", Range::positive());
    r.rest = n.quantity_or("rest", 0, "s", Range::non_negative());
  }
  n.finish();
  std::string& t = r.inputs;
  t = p.soil_text;
  for (const auto& [name, value] : {std::pair{"radius_m", p.radius},
                                    {"width_m", p.width},
                                    {"slab_m", p.slab},
                                    {"bed_depth_m", p.depth},
                                    {"relief_m", p.relief},
                                    {"reach_m", p.reach},
                                    {"period_m", p.period},
                                    {"speed_m_s", p.speed},
                                    {"sample_s", p.sample},
                                    {"column_m", p.column},
                                    {"seed", static_cast<double>(r.seed)},
                                    {"start_m", r.start},
                                    {"load_N", r.load},
                                    {"depth_m", r.depth},
                                    {"swing_m", r.swing},
                                    {"length_m", r.length},
                                    {"distance_m", r.distance},
                                    {"rest_s", r.rest}})
    put(t, name, value);
  for (const double s : r.slips) put(t, "slip", s);
  for (const double f : r.press) put(t, "press_N", f);
  if (p.walls) t += "sides walls\n";
  t += "ground " + r.ground->describe() + "\ntraining 1\n";
  r.name = dem::hash_text(t);
  return r;
}

/// Every array of a record: name, unit, meaning, values.
template <class Record, class F>
void each_array(Record& r, F&& f) {
  f("time_s", "s", "end of the sample", r.time);
  f("x", "m", "hub", r.x);
  f("z", "m", "hub", r.z);
  f("vx", "m/s", "mean over the sample", r.vx);
  f("vz", "m/s", "mean over the sample", r.vz);
  f("spin", "rad/s", "at the end", r.spin);
  f("fx", "N", "soil on wheel, mean over the sample", r.fx);
  f("fz", "N", "soil on wheel, mean over the sample", r.fz);
  f("torque", "N m", "soil on wheel about the axle, mean over the sample", r.torque);
  f("free", "1", "1: height free under the load", r.free);
  f("profile", "m", "mean over the slab of the highest grain, profiles x columns", r.profile);
}

std::string content_hash(TrainingRecord r) {
  State s;
  each_array(r, [&](const char* name, const char*, const char*, const std::vector<float>& v) {
    std::vector<std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(v.data()),
                                    reinterpret_cast<const std::uint8_t*>(v.data() + v.size()));
    s.field(name, bytes);
  });
  s.field("profile_sample", r.profile_sample);
  s.field("profile_column", r.profile_column);
  return s.hash_text();
}

}  // namespace

double TrainingRun::seconds(const TrainingPlan& p) const {
  double t = 0.6 + rest + 0.8 * static_cast<double>(press.size());
  for (const double s : slips)
    t += distance / static_cast<double>(slips.size()) / (s > 0 ? p.speed * (1 - s) : p.speed);
  return t;
}

TrainingPlan load_training(const fs::path& file, std::vector<TrainingRun>& runs) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  TrainingPlan p;
  p.title = root.text("training");
  p.source = root.text_or("source", "");
  const auto from_file = [&](const char* key, auto&& load) {
    const fs::path named = root.existing_file(key);
    if (!fs::is_regular_file(named)) return;
    try {
      load(named);
    } catch (const ConfigError& e) {
      for (const Diagnostic& d : e.diagnostics()) root.report(d);
    }
  };
  from_file("wheel", [&](const fs::path& f) {
    const RunningGear gear = load_running_gear_file(f);
    p.wheel = gear.name;
    p.radius = gear.radius();
    p.width = gear.width();
    if (!std::holds_alternative<SmoothCylinder>(gear.shape))
      root.error_at("wheel", "'" + gear.name + "' is no smooth cylinder");
  });
  from_file("soil", [&](const fs::path& f) {
    p.soil = load_soil_file(f);
    p.soil_text = soil_text(p.soil.dem);
    if (p.soil_text.empty()) root.error_at("soil", "'" + p.soil.name + "' has no section 'dem:'");
  });
  const ConfigNode g = root.map("grains");
  p.slab = g.quantity("slab", "m", Range::positive());
  p.depth = g.quantity("depth", "m", Range::positive());
  p.relief = g.quantity("relief", "m", Range::non_negative());
  p.reach = g.quantity("reach", "m", Range::positive());
  p.period = g.quantity("period", "m", Range::positive());
  p.walls = g.choice_or("sides", "periodic", {"periodic", "walls"}) == "walls";
  g.finish();
  p.speed = root.quantity("speed", "m/s", {0, 1, true, false});
  p.sample = root.quantity_or("sample", p.sample, "s", {0, 0.1, true, false});
  p.column = root.quantity_or("column", p.column, "m", {0, 0.1, true, false});
  for (const ConfigNode& n : root.list("runs")) runs.push_back(read_run(n, p));
  root.finish();
  doc.check();
  return p;
}

void write_training(const TrainingRecord& record, const TrainingRun& r, const fs::path& file) {
  write_whole(file, [&](const fs::path& part) {
    {
      Recorder out = Recorder::create(part, {kKind, r.inputs, "training run", "sdem", GROUSER_VERSION, r.seed});
      out.set_attribute("hash", content_hash(record));
      out.set_attribute("processor_s", record.processor);
      for (const auto& [name, v] :
           {std::pair{"profile_sample", &record.profile_sample}, {"profile_column", &record.profile_column}}) {
        const std::vector<double> x(v->begin(), v->end());
        out.write_static({name, "1", "of each profile", "", 1}, x, {x.size()});
      }
      out.close();
    }
    std::vector<CompactArray> arrays;
    each_array(record, [&](const char* name, const char* unit, const char* what, const std::vector<float>& v) {
      arrays.push_back({{name, unit, what, "W", 1}, v, {v.size()}});
    });
    add_compact(part, arrays);
  });
}

TrainingRecord read_training(const TrainingRun& r, const fs::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != kKind) fail("is a " + in.attributes().kind + ", not a training run");
  if (in.attributes().scenario != r.inputs) fail("is a run of other inputs than its name says; remove it");
  TrainingRecord out;
  each_array(out, [&](const char* name, const char*, const char*, std::vector<float>& v) {
    const std::vector<double> x = in.read(name);
    v.assign(x.begin(), x.end());
  });
  for (const auto& [name, v] :
       {std::pair{"profile_sample", &out.profile_sample}, {"profile_column", &out.profile_column}}) {
    const std::vector<double> x = in.read(name);
    v->assign(x.begin(), x.end());
  }
  out.processor = in.number("processor_s", 0);
  if (content_hash(out) != in.attribute("hash"))
    fail("is damaged: its content does not match its stored hash; remove it, the run is made again");
  return out;
}

}  // namespace grouser::sdem
