// The soil file of a fit: every value with the data and the fit it came from.
#include <cmath>
#include <cstdio>

#include "grouser/terrain/loaders.h"
#include "sections.h"

namespace grouser::diagnosis {
namespace {

std::string exact(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.8g", x);
  return text;
}

std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) out += (c == '"' || c == '\\') ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

struct Writer {
  const SoilDraft& draft;
  std::string text;
  void value(const std::string& group, const std::string& key, const std::string& number) {
    const auto at = draft.origin.find(group.empty() ? key : group + "." + key);
    const bool assumed = at == draft.origin.end() || at->second.assumed;
    const std::string why = at == draft.origin.end() ? "left open by the sources" : at->second.text;
    text += std::string(group.empty() ? "" : "    ") + key + ": {" + (assumed ? "assumed: " : "value: ") + number +
            (assumed ? ", why: " : ", source: ") + quoted(why) + "}\n";
  }
};

}  // namespace

SoilDraft draft_of_file(const ConfigNode& node, const std::string& key) {
  SoilDraft d;
  const std::filesystem::path file = node.existing_file(key);
  if (!std::filesystem::is_regular_file(file)) return d;
  const ConfigDocument document = ConfigDocument::from_file(file);
  const Soil soil = load_soil(document.root());
  for (const Diagnostic& e : document.diagnostics()) node.report(e);
  if (!document.diagnostics().empty()) return d;
  if (!soil.bekker) {
    node.error_at(key, "soil '" + soil.name + "' has no 'bekker:' section");
    return d;
  }
  d.soil = *soil.bekker;
  d.bulk_density = soil.bulk_density;
  const std::string source = file.filename().string() + ": " + soil.source;
  const auto take = [&](const std::string& k) {
    d.put(k, source);
    for (const Assumption& a : document.assumptions())
      if (a.key == "bekker." + k || a.key == k) d.origin[k] = {a.why, true};
  };
  const bool k_b = d.soil.pressure.law == PressureSinkage::Law::k_b;
  for (const char* k : {"pressure.n", "pressure.reference_width"}) take(k);
  if (k_b)
    take("pressure.k");
  else
    take("pressure.kc"), take("pressure.kphi");
  for (const char* k : {"shear.cohesion", "shear.friction_angle", "shear.K", "shear.Kw", "shear.Kr"}) take(k);
  for (const char* k :
       {"contact_angles.a0", "contact_angles.a1", "contact_angles.b0", "contact_angles.b1", "bulk_density"})
    take(k);
  for (const Assumption& a : document.assumptions())
    if (a.key == "bekker.contact_angles")
      for (const char* k : {"a0", "a1", "b0", "b1"}) d.origin[std::string("contact_angles.") + k] = {a.why, true};
  return d;
}

std::pair<std::string, std::string> soil_file_text(const std::string& name, const std::string& source,
                                                   const SoilDraft& d) {
  if (!d.has_pressure() || !d.has_shear())
    return {"", std::string("no soil file: ") + (d.has_pressure() ? "the shear" : "the pressure") +
                    " values are missing; fit them too or name a soil file as base_soil"};
  Writer w{d, {}};
  const PressureSinkage& p = d.soil.pressure;
  w.text = "soil: " + quoted(name) + "\nsource: " + quoted(source) + "\nbekker:\n  pressure:\n";
  if (p.law == PressureSinkage::Law::k_b) {
    w.text += "    law: k_b\n";
    w.value("pressure", "k", exact(p.k) + " Pa");
  } else {
    w.text += "    law: kc_kphi\n";
    w.value("pressure", "kc", exact(p.kc) + " N/m^(n+1)");
    w.value("pressure", "kphi", exact(p.kphi) + " N/m^(n+2)");
  }
  w.value("pressure", "n", exact(p.n));
  w.value("pressure", "reference_width", p.reference_width > 0 ? exact(p.reference_width) + " m" : "wheel");
  const ShearLaw& s = d.soil.shear;
  w.text += std::string("  shear:\n    type: ") +
            (s.type == ShearLaw::Type::A   ? "A"
             : s.type == ShearLaw::Type::B ? "B"
                                           : "C") +
            "\n";
  w.value("shear", "cohesion", exact(s.cohesion) + " Pa");
  w.value("shear", "friction_angle", exact(s.friction_angle) + " rad");
  if (s.type == ShearLaw::Type::A)
    w.value("shear", "K", exact(s.K) + " m");
  else
    w.value("shear", "Kw", exact(s.Kw) + " m");
  if (s.type == ShearLaw::Type::C) w.value("shear", "Kr", exact(s.Kr));
  w.text += "  contact_angles:\n";
  const ContactAngles& a = d.soil.angles;
  w.value("contact_angles", "a0", exact(a.a0));
  w.value("contact_angles", "a1", exact(a.a1));
  w.value("contact_angles", "b0", exact(a.b0));
  w.value("contact_angles", "b1", exact(a.b1));
  if (d.soil.repetitive)
    w.text += "  repetitive: {ko: " + exact(d.soil.repetitive->ko) + " N/m^3, Au: " + exact(d.soil.repetitive->Au) +
              " N/m^4}\n";
  if (d.bulk_density > 0) w.value("", "bulk_density", exact(d.bulk_density) + " kg/m^3");
  // What the program writes it must also read.
  const ConfigDocument document = ConfigDocument::from_text(w.text, "soil.yaml");
  load_soil(document.root());
  if (document.diagnostics().empty()) return {w.text, ""};
  std::string why = "no soil file: the fitted values make no soil:";
  for (const Diagnostic& e : document.diagnostics()) why += " " + e.message + ";";
  return {"", why};
}

}  // namespace grouser::diagnosis
