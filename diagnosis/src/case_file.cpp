#include <algorithm>
#include <cmath>

#include "effect_list.h"
#include "grouser/diagnosis/runs.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/registry.h"
#include "rig_case.h"

namespace grouser::diagnosis {

const std::array<ChannelName, channel_count>& channel_names() {
  static const std::array<ChannelName, channel_count> names{{{"drawbar_N", "drawbar_sd_N", "drawbar", "N"},
                                                             {"torque_Nm", "torque_sd_Nm", "torque", "N m"},
                                                             {"sinkage_m", "sinkage_sd_m", "sinkage", "m"}}};
  return names;
}

const std::array<SoilCoordinate, soil_count>& soil_coordinates() {
  static const std::array<SoilCoordinate, soil_count> list{{{"k", "Pa", true, std::log(10.0), std::log(1e11)},
                                                            {"n", "1", false, 0.1, 4},
                                                            {"c", "Pa", false, 0, 1e5},
                                                            {"phi", "rad", false, 0.02, 1.4},
                                                            {"K", "m", true, std::log(2e-5), std::log(0.3)},
                                                            {"a0", "1", false, -0.2, 0.95},
                                                            {"a1", "1", false, -0.5, 1.2}}};
  return list;
}

namespace {

/// {value: 254 kPa, ln_sd: 0.3}, {value: 0.6 rad, sd: 0.05 rad}, or a value alone: held fixed.
SoilPrior read_prior(const ConfigNode& parent, const SoilCoordinate& c) {
  SoilPrior p;
  const ConfigNode node = parent.node(c.name);
  if (!node.present()) {
    parent.quantity(c.name, c.unit);  // notes that it is missing
    return p;
  }
  const Range range = c.logarithmic ? Range::positive() : Range::any();
  if (node.is_map()) {
    const double value = node.quantity("value", c.unit, range);
    p.mean = c.logarithmic ? std::log(value) : value;
    if (c.logarithmic)
      p.sd = node.quantity_or("ln_sd", 0, "1", Range::non_negative());
    else
      p.sd = node.quantity_or("sd", 0, c.unit, Range::non_negative());
    node.text_or("source", "");
    node.finish();
  } else {
    const double value = node.as_quantity(c.unit, range);
    p.mean = c.logarithmic ? std::log(value) : value;
  }
  return p;
}

std::vector<std::string> read_effects(const ConfigNode& root) {
  const std::vector<std::string> known = effect_ids();
  const ConfigNode node = root.node("effects");
  if (!node.present() || (node.is_scalar() && node.as_text() == "all")) return known;
  std::vector<std::string> out;
  if (!node.is_list()) {
    std::string all;
    for (const std::string& id : known) all += (all.empty() ? "" : ", ") + id;
    node.error("effects: all, or a list of ids: " + all);
    return known;
  }
  for (const ConfigNode& item : node.items()) {
    const std::string id = item.as_text();
    if (std::find(known.begin(), known.end(), id) == known.end()) {
      const auto near = did_you_mean(id, known);
      item.error("no effect '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
    } else {
      out.push_back(id);
    }
  }
  return out;
}

/// Id of an effect under `parent`; -1 and an error where there is none.
int entry_under(const ConfigNode& parent, const std::string& id) {
  const int entry = entry_of(id);
  if (entry >= 0) return entry;
  const auto near = did_you_mean(id, effect_ids());
  parent.error_at(id, "no effect '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
  return entry;
}

/// Unit in which a file states the amplitude.
std::string written_unit(const EffectEntry& e) { return e.shown != 1 ? "rad" : e.unit; }

/// known_effects: {slip_sinkage_exponent: 0.86, lugs: {value: 8 mm, sd: 1 mm}}
void read_known(const ConfigNode& root, DiagnosisCase& c) {
  const ConfigNode known = root.optional_map("known_effects");
  if (!known.present()) return;
  for (const std::string& id : known.keys()) {
    const int entry = entry_under(known, id);
    const ConfigNode node = known.node(id);
    if (entry < 0) continue;
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
    KnownEffect k{id, 0, 0};
    if (node.is_map()) {
      k.value = node.quantity("value", written_unit(e));
      k.sd = node.quantity_or("sd", 0, written_unit(e), Range::non_negative());
      node.text_or("source", "");
      node.finish();
    } else {
      k.value = node.as_quantity(written_unit(e));
    }
    if (e.inverse && k.value != 0) k.sd /= k.value * k.value, k.value = 1 / k.value;
    if (root.errors() == 0 && (k.value < e.lower || k.value > e.upper))
      node.error("the amplitude of " + id + " is outside what is physical: " + std::to_string(e.lower) + " to " +
                 std::to_string(e.upper) + (e.inverse ? " 1/" : " ") + written_unit(e));
    c.known.push_back(k);
  }
  known.finish();
}

/// amplitudes: {wheel_radius_error: {sd: 0.02}}
void read_amplitudes(const ConfigNode& root, DiagnosisCase& c) {
  const ConfigNode all = root.optional_map("amplitudes");
  if (!all.present()) return;
  for (const std::string& id : all.keys()) {
    const int entry = entry_under(all, id);
    const ConfigNode node = all.map(id);
    if (entry < 0) continue;
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
    const std::string unit = e.inverse ? "1/" + e.unit : written_unit(e);
    c.amplitude_sd[id] = node.quantity("sd", unit, Range::positive());
    node.text_or("source", "");
    node.finish();
  }
  all.finish();
}

/// judge: {k: 23.05 kPa, n: 0.418}: values from elsewhere, to be held against the priors.
void read_judged(const ConfigNode& root, DiagnosisCase& c) {
  const ConfigNode node = root.optional_map("judge");
  if (!node.present()) return;
  const auto& list = soil_coordinates();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!node.has(list[i].name)) continue;
    const double value =
        node.quantity(list[i].name, list[i].unit, list[i].logarithmic ? Range::positive() : Range::any());
    c.judged[i] = list[i].logarithmic ? std::log(value) : value;
    if (!(c.soil[i].sd > 0))
      node.error_at(list[i].name, std::string("the case gives ") + list[i].name + " no " +
                                      (list[i].logarithmic ? "ln_sd" : "sd") + ", so nothing can be judged by it");
  }
  node.finish();
}

}  // namespace

DiagnosisCase read_case(const std::filesystem::path& yaml, const Registry* registry) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode root = document.root();
  DiagnosisCase c;
  c.file = yaml;
  std::vector<std::string> models{"bekker.steady"};
  if (registry)
    for (const ModelInfo& m : registry->models())
      if (m.id != models[0]) models.push_back(m.id);
  c.model = root.choice("model", models);
  const ConfigNode wheel = root.map("wheel");
  c.wheel.radius = wheel.quantity("radius", "m", Range::positive());
  c.wheel.width = wheel.quantity("width", "m", Range::positive());
  c.mass = wheel.quantity_or("mass", 0, "kg", Range::non_negative());
  wheel.finish();
  const ConfigNode soil = root.map("soil");
  const ConfigNode pressure = soil.map("pressure"), shear = soil.map("shear"), angles = soil.map("angles");
  pressure.choice_or("law", "k_ref", {"k_ref"});
  c.wheel.reference_width = pressure.quantity("reference_width", "m", Range::positive());
  shear.choice_or("type", "A", {"A"});
  const auto& list = soil_coordinates();
  const ConfigNode parents[soil_count] = {pressure, pressure, shear, shear, shear, angles, angles};
  for (std::size_t i = 0; i < soil_count; ++i) {
    c.soil[i] = read_prior(parents[i], list[i]);
    if (root.errors() == 0 && (c.soil[i].mean < list[i].lower || c.soil[i].mean > list[i].upper))
      parents[i].error_at(list[i].name, std::string(list[i].name) + " is outside what the law allows");
  }
  pressure.finish(), shear.finish(), angles.finish();
  const ConfigNode density = soil.node("density");
  if (density.is_map() && !density.has("source")) {
    c.wheel.constants.density = density.quantity("value", "kg/m^3", Range::positive());
    density.finish();
  } else if (density.present()) {
    c.wheel.constants.density = density.as_quantity("kg/m^3", Range::positive());
  }
  soil.finish();
  c.effects = read_effects(root);
  read_known(root, c);
  read_amplitudes(root, c);
  read_judged(root, c);
  root.node("series");  // read by read_time_case
  // With the key `rig` the steady law is rolled, too.
  const bool rolled = registry && (c.model != "bekker.steady" || root.has("rig"));
  if (rolled) read_rig(root, c);
  if (rolled && root.errors() == 0 && registry->has(c.model)) use_rig(root, registry->get(c.model), c);
  root.finish();
  document.check();
  return c;
}

}  // namespace grouser::diagnosis
