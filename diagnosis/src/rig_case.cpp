#include "rig_case.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rig_model.h"

namespace grouser::diagnosis {
namespace {

/// "key: value" lines of a map of plain values.
std::string lines_of(const ConfigNode& map) {
  std::string out;
  if (!map.present()) return out;
  for (const std::string& key : map.keys()) {
    const ConfigNode value = map.node(key);
    if (value.is_scalar())
      out += key + ": " + value.as_text() + "\n";
    else
      value.error("a single value is wanted here; lists and maps of a model's options cannot be rolled in the rig");
  }
  return out;
}

std::string short_length(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g m", metres);
  return text;
}

std::string list(const std::vector<std::string>& ids) {
  std::string out;
  for (const std::string& id : ids) out += (out.empty() ? "" : ", ") + id;
  return out;
}

}  // namespace

RigOfCase::RigOfCase() = default;
RigOfCase::~RigOfCase() = default;
RigOfCase::RigOfCase(RigOfCase&&) noexcept = default;
RigOfCase& RigOfCase::operator=(RigOfCase&&) noexcept = default;
RigOfCase::RigOfCase(const RigOfCase& o)
    : options(o.options),
      coarse(o.coarse),
      step(o.step),
      average_over(o.average_over),
      settle(o.settle),
      sinkage_from_rut(o.sinkage_from_rut),
      model_(o.model_ ? std::make_unique<RigModel>(*o.model_) : nullptr) {}
RigOfCase& RigOfCase::operator=(const RigOfCase& o) { return *this = RigOfCase(o); }
void RigOfCase::set(std::unique_ptr<RigModel> m) { model_ = std::move(m); }

void read_rig(const ConfigNode& root, DiagnosisCase& c) {
  const ConfigNode rig = root.optional_map("rig");
  RigOfCase& r = c.rig;
  // A thirtieth of these is the step; node spacings as long as the average are coarse and give the same means.
  r.average_over = rig.quantity_or("average_over", 0.115 * c.wheel.radius, "m", Range::positive());
  r.step = rig.quantity_or("step", r.average_over / 30, "m", Range::positive());
  r.settle = rig.quantity_or("settle", 1.2, "1", Range::between(0.1, 100));
  r.sinkage_from_rut = rig.choice_or("sinkage_from", "undisturbed", {"undisturbed", "rut"}) == "rut";
  r.options = lines_of(rig.optional_map("options"));
  if (rig.has("coarse"))
    r.coarse = lines_of(rig.optional_map("coarse"));
  else if (c.model == "bekker.soil_node")  // the one default that belongs to a model
    r.coarse = "spacing: " + short_length(r.average_over) + "\n";
  if (root.errors() == 0 && !(r.step <= r.average_over))
    rig.error_at("step", "the step must not be longer than average_over, " + short_length(r.average_over));
  rig.finish();
}

void use_rig(const ConfigNode& root, const ModelInfo& model, DiagnosisCase& c) {
  RigNumerics numerics;
  numerics.step = c.rig.step, numerics.average_over = c.rig.average_over, numerics.settle = c.rig.settle;
  try {
    c.rig.set(std::make_unique<RigModel>(
        RigDriver(model, c.rig.options + c.rig.coarse, c.file.string() + " (rig.options and rig.coarse)", numerics),
        c.wheel, c.soil, c.rig.sinkage_from_rut));
  } catch (const std::invalid_argument& e) {
    root.error_at("model", std::string("model ") + model.id + " cannot be made from the soil of a case: " + e.what());
    return;
  } catch (const ConfigError& e) {
    for (Diagnostic d : e.diagnostics()) root.report(std::move(d));
    return;
  }
  const RigModel& rig = *c.rig.model();
  c.notes = rig.notes();
  std::vector<std::string> has;
  const auto lacks = [&](const std::string& id) {
    const int e = entry_of(id);
    return e >= 0 && e < model_effects && !rig.has(e);
  };
  for (const EffectEntry& e : effect_entries())
    if (!lacks(e.id)) has.push_back(e.id);
  const bool listed = root.node("effects").is_list();
  for (const std::string& id : c.effects)
    if (listed && lacks(id))
      root.error_at("effects", "model " + c.model + " does not have '" + id +
                                   "', or does not show it in steady runs; it has " + list(has));
  std::erase_if(c.effects, lacks);
  for (const KnownEffect& k : c.known)
    if (lacks(k.id))
      root.error_at("known_effects", "model " + c.model + " does not have '" + k.id +
                                         "', or does not show it in steady runs; it has " + list(has));
  std::string held;
  for (int i = 0; i < soil_count; ++i)
    if (!rig.feels(i)) {
      c.soil[static_cast<std::size_t>(i)].sd = 0;
      held += (held.empty() ? "" : ", ") + std::string(soil_coordinates()[static_cast<std::size_t>(i)].name);
    }
  if (!held.empty())
    c.notes.push_back("soil values that change nothing in this model, and that are not refitted: " + held);
}

}  // namespace grouser::diagnosis
