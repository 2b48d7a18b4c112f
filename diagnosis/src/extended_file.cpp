#include <cstdio>
#include <fstream>

#include "effect_list.h"
#include "grouser/diagnosis/diagnose.h"
#include "grouser/terrain/recorder.h"

namespace grouser::diagnosis {
namespace {

std::string exact(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

}  // namespace

std::string extended_case_text(const Diagnosis& d, const DiagnosisCase& c) {
  const auto value = [&](const char* name) {
    const auto found = d.extended.parameters.find(name);
    if (found != d.extended.parameters.end()) return found->second.value;
    for (std::size_t i = 0; i < soil_count; ++i)
      if (std::string(soil_coordinates()[i].name) == name)
        return soil_coordinates()[i].logarithmic ? std::exp(c.soil[i].mean) : c.soil[i].mean;
    return 0.0;
  };
  std::string out = "# " + d.sentence + "\nmodel: " + c.model + "\nwheel: {radius: " + exact(c.wheel.radius) +
                    " m, width: " + exact(c.wheel.width) + " m";
  if (c.mass > 0) out += ", mass: " + exact(c.mass) + " kg";
  out += "}\nsoil:\n  pressure: {law: k_ref, reference_width: " + exact(c.wheel.reference_width) +
         " m, k: " + exact(value("k")) + " Pa, n: " + exact(value("n")) +
         "}\n  shear: {type: A, c: " + exact(value("c")) + " Pa, phi: " + exact(value("phi")) +
         " rad, K: " + exact(value("K")) + " m}\n  angles: {a0: " + exact(value("a0")) + ", a1: " + exact(value("a1")) +
         "}\n  density: " + exact(c.wheel.constants.density) + " kg/m^3\n";
  std::string model, map;
  for (const auto& [id, amplitude] : d.parameters) {
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry_of(id))];
    const std::string line = "  " + id + ": {value: " + exact(amplitude.value) +
                             (amplitude.unit == "1" ? "" : " " + amplitude.unit) + ", sd: " + exact(amplitude.sd) +
                             "}\n";
    (e.is_map ? map : model) += line;
  }
  if (!model.empty()) out += "model_effects:\n" + model;
  if (!map.empty()) out += "measurement:  # of the rig; a vehicle never feels it\n" + map;
  return out;
}

}  // namespace grouser::diagnosis
