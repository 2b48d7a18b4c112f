#include "grouser/diagnosis/extended_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "effect_list.h"

namespace grouser::diagnosis {
namespace {

std::string exact(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", x);
  return text;
}

std::string unit_of(const Interval& i) { return i.unit == "1" ? "" : " " + i.unit; }

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
  std::string known;
  for (const auto& [id, amplitude] : d.parameters)
    known += "  " + id + ": " + exact(amplitude.value) + unit_of(amplitude) + "  # +- " + exact(amplitude.sd) +
             (effect_entries()[static_cast<std::size_t>(entry_of(id))].is_map ? "; of the rig: a vehicle never feels it"
                                                                              : "") +
             "\n";
  if (!known.empty()) out += "known_effects:\n" + known;
  if (!c.rig.model()) return out;
  const auto flow = [](const std::string& lines) {
    std::string map;
    for (const char x : lines) map += x == '\n' ? std::string(", ") : std::string(1, x);
    if (!map.empty()) map.resize(map.size() - 2);
    return "{" + map + "}";
  };
  return out + "rig: {step: " + exact(c.rig.step) + " m, average_over: " + exact(c.rig.average_over) +
         " m, settle: " + exact(c.rig.settle) + ", sinkage_from: " + (c.rig.sinkage_from_rut ? "rut" : "undisturbed") +
         ", options: " + flow(c.rig.options) + ", coarse: " + flow(c.rig.coarse) + "}\n";
}

namespace {

std::string short_number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

/// In double quotes, on one line.
std::string in_quotes(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

std::string comment(const std::string& s) {
  std::string out = "# ";
  for (const char c : s) out += c == '\n' ? ' ' : c;
  return out + "\n";
}

/// Different values in rising order.
std::vector<double> different(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end(),
                      [](double a, double b) { return std::abs(a - b) <= 1e-4 * std::max(1.0, std::abs(a)); }),
          v.end());
  return v;
}

std::string list(const std::vector<double>& v, const std::string& unit) {
  std::string out = "[";
  for (const double x : v) out += (out.size() > 1 ? ", " : "") + exact(x) + unit;
  return out + "]";
}

bool is_physics(const std::string& id) { return bekker::effect_of(id).has_value(); }

/// Amplitude as the model takes it: 1/H for what a person reads as H.
std::string amplitude_text(const std::string& id, const Interval& i) {
  const bekker::EffectInfo& e = bekker::effect_table()[static_cast<std::size_t>(*bekker::effect_of(id))];
  const double value = e.inverse ? 1 / i.value : i.value;
  std::string unit = e.unit == "1" ? "" : " " + std::string(e.unit);
  if (e.inverse) unit = " 1/" + std::string(e.unit);
  std::string source = short_number(i.value) + " +- " + short_number(i.sd) + unit_of(i) + ", 90 % in " +
                       short_number(i.low) + " to " + short_number(i.high) + unit_of(i) +
                       (i.at_bound ? ", at its bound" : "");
  return "{value: " + exact(value) + unit + ", source: " + in_quotes(source + "; " + std::string(e.source)) + "}";
}

std::string effects_of(const Diagnosis& d, const std::string& indent) {
  std::string out;
  for (const auto& [id, amplitude] : d.parameters)
    if (is_physics(id)) out += indent + id + ": " + amplitude_text(id, amplitude) + "\n";
  return out;
}

class Soil {
 public:
  Soil(const Diagnosis& d, const DiagnosisCase& c) : d_(d), c_(c) {}
  /// "{value: 2.5e5 Pa, source: ...}"
  std::string value(const char* name, const char* unit) const {
    std::string source = "as the case gives it";
    double v = 0;
    for (std::size_t i = 0; i < soil_count; ++i)
      if (std::string(soil_coordinates()[i].name) == name)
        v = soil_coordinates()[i].logarithmic ? std::exp(c_.soil[i].mean) : c_.soil[i].mean;
    if (const auto found = d_.extended.parameters.find(name); found != d_.extended.parameters.end()) {
      v = found->second.value;
      source = "fitted, +- " + short_number(found->second.sd) + (*unit ? " " : "") + unit + ", " +
               short_number(found->second.prior_z) + " standard deviations from its prior";
    }
    return "{value: " + exact(v) + (*unit ? " " : "") + unit + ", source: " + in_quotes(source) + "}";
  }
  std::string text(const std::string& title, const std::string& source) const {
    return "soil: " + in_quotes(title) + "\nsource: " + in_quotes(source) +
           "\nbekker:\n  pressure:\n    law: k_b\n    k: " + value("k", "Pa") + "\n    n: " + value("n", "") +
           "\n    reference_width: " + exact(c_.wheel.reference_width) +
           " m\n  shear:\n    type: A\n    cohesion: " + value("c", "Pa") +
           "\n    friction_angle: " + value("phi", "rad") + "\n    K: " + value("K", "m") +
           "\n  contact_angles:\n    a0: " + value("a0", "") + "\n    a1: " + value("a1", "") +
           "\n    b0: 0\n    b1: 0\nbulk_density: " + exact(c_.wheel.constants.density) + " kg/m^3\n";
  }

 private:
  const Diagnosis& d_;
  const DiagnosisCase& c_;
};

/// Means of what lies within `width` of each other: dead weights and slips of repeats are never quite the same.
std::vector<double> merged(std::vector<double> x, double width) {
  std::sort(x.begin(), x.end());
  std::vector<double> out;
  for (std::size_t i = 0; i < x.size();) {
    std::size_t j = i;
    double sum = 0;
    for (; j < x.size() && x[j] - x[i] <= width; ++j) sum += x[j];
    out.push_back(sum / static_cast<double>(j - i));
    i = j;
  }
  return out;
}

std::string rig_text(const Diagnosis& d, const DiagnosisCase& c, const std::string& title, const std::string& source) {
  std::vector<double> loads, slips, speeds;
  int greatest_pass = 1, locked = 0;
  for (const Run& r : d.runs) {
    greatest_pass = std::max(greatest_pass, r.pass);
    loads.push_back(r.load);
    if (!(r.omega > 0) || r.slip <= -0.999 || r.slip >= 0.999) {
      ++locked;
      continue;
    }
    slips.push_back(r.slip);
    speeds.push_back(r.omega);
  }
  std::string out = comment(title + ": the wheel of the runs on the extended model. " + d.sentence);
  for (const auto& [id, amplitude] : d.parameters)
    if (!is_physics(id))
      out += comment("of the rig, not of the soil, and so not simulated: " + id + " " + short_number(amplitude.value) +
                     " +- " + short_number(amplitude.sd) + unit_of(amplitude));
  if (locked > 0) out += comment(std::to_string(locked) + " runs without rolling or without travel are left out");
  out += "rig: " + in_quotes(title) + "\nsource: " + in_quotes(source) + "\nwheel: extended_wheel.yaml\n";
  out += "terrain:\n  model: " + c.model + "\n  soil: extended_soil.yaml\n";
  const bool passes = d.parameters.contains("repetitive_loading") || d.parameters.contains("pass_strength");
  const bool order = d.parameters.contains("preparation_drift");
  if (c.rig.model()) {
    if (passes)
      out +=
          comment("the rig makes one pass: effects of a later pass act where a wheel follows another, as in a vehicle");
    if (!c.rig.options.empty()) {
      out += "  options:\n    " + c.model + ":\n      ";
      for (const char x : c.rig.options) out += x == '\n' ? std::string("\n      ") : std::string(1, x);
      out.resize(out.size() - 6);
    }
  } else if ((passes && greatest_pass >= 2) || order) {
    out += "  options:\n    " + c.model + ":\n";
    if (passes && greatest_pass >= 2)
      out += "      pass: 2   # 1: the first pass, as if these effects were not there\n";
    if (order) out += "      order: 0  # 0..1 from the first to the last run of the series\n";
  }
  if (const std::string effects = effects_of(d, "      "); !effects.empty())
    out += "  effects:\n    " + c.model + ":\n" + effects;
  out += "load: " + list(merged(loads, 0.15 * *std::max_element(loads.begin(), loads.end())), " N") + "\n";
  if (slips.empty()) {  // nothing rolled: the rig still shows the wheel
    slips = {0.1, 0.3};
    speeds = {0.1};
  }
  std::sort(speeds.begin(), speeds.end());
  const std::vector<double> all = different(speeds);
  out += "slips: " + list(merged(slips, 0.03), "") + "\nslip_definition: symmetric\n";
  out += "angular_speed: " + exact(speeds[speeds.size() / 2]) + " rad/s";
  if (all.size() > 1) out += "  # the runs had " + list(all, "") + " rad/s";
  out += "\ndistance: " + exact(5 * c.wheel.radius) + " m\naverage_over: 20 %\noutput: {rate: 20 Hz}\n";
  return out;
}

}  // namespace

std::vector<ExtendedFile> extended_files(const Diagnosis& d, const DiagnosisCase& c) {
  const std::string title = "extended model of " + c.file.stem().string();
  const std::string source = "grouser diagnose: " + d.sentence;
  std::vector<ExtendedFile> out{{"extended.yaml", rig_text(d, c, title, source)}};
  out.push_back({"extended_wheel.yaml", "wheel: " + in_quotes("wheel of " + c.file.stem().string()) +
                                            "\nsource: " + in_quotes("case " + c.file.filename().string()) +
                                            "\nshape: smooth\nradius: " + exact(c.wheel.radius) +
                                            " m\nwidth: " + exact(c.wheel.width) + " m\n"});
  out.push_back({"extended_soil.yaml", Soil(d, c).text(title, source)});
  if (const std::string effects = effects_of(d, "    "); !effects.empty())
    out.push_back({"extended_effects.yaml", "effects: " + in_quotes(title) + "\nsource: " + in_quotes(source) +
                                                "\namplitudes:\n  " + c.model + ":\n" + effects});
  out.push_back({"extended_case.yaml", extended_case_text(d, c)});
  return out;
}

}  // namespace grouser::diagnosis
