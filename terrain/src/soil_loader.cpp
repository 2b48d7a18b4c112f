// Soil files: every number with unit and range, and the sanity of the numbers together.
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/types.h"
#include "units.h"

namespace grouser {
namespace {

constexpr double plate_width = 0.05;  // [m] short side of the plate that k_b soils are fitted with unless they say so
constexpr double narrowest = 0.01;    // [m] no wheel here is narrower

void check_modulus(const ConfigNode& node, const PressureSinkage& p) {
  const bool of_wheel = p.reference_width == 0;
  if (p.modulus(narrowest) > 0) return;
  if (!of_wheel) {
    node.error("the modulus kc/b + kphi is not positive at the reference width b = " +
               units::number(1000 * p.reference_width) +
               " mm; check the signs of kc and kphi or take a wider reference");
  } else if (p.kphi > 0) {
    node.error("kc is negative: the modulus kc/b + kphi is not positive for wheels narrower than " +
               units::number(-1000 * p.kc / p.kphi) + " mm; state the plate's width as reference_width");
  } else {
    node.error("the modulus kc/b + kphi is not positive for every wheel; check the signs of kc and kphi");
  }
}

PressureSinkage load_pressure(const ConfigNode& node) {
  PressureSinkage p;
  const std::size_t before = node.errors();
  const bool k_b = node.choice("law", {"kc_kphi", "k_b"}) == "k_b";
  p.law = k_b ? PressureSinkage::Law::k_b : PressureSinkage::Law::kc_kphi;
  p.n = node.quantity("n", "1", Range::between(0.05, 4));
  // kc and kphi have n in their units: without n they cannot be read.
  const bool n_known = node.errors() == before;
  if (k_b) {
    p.k = node.quantity("k", "kPa", {0, 1e12, true, false});
    for (const char* other : {"kc", "kphi"})
      if (node.has(other)) node.error_at(other, "belongs to 'law: kc_kphi'; with 'law: k_b' give k");
  } else {
    if (n_known || !node.has("kc")) p.kc = node.quantity_n("kc", "kN/m^(n+1)", p.n);
    if (n_known || !node.has("kphi")) p.kphi = node.quantity_n("kphi", "kN/m^(n+2)", p.n);
    if (node.has("k")) node.error_at("k", "belongs to 'law: k_b'; with 'law: kc_kphi' give kc and kphi");
  }
  p.reference_width = k_b ? plate_width : 0;
  const ConfigNode width = node.node("reference_width");
  if (!width.present()) {
    node.assume("reference_width", k_b ? "50 mm" : "wheel",
                k_b ? "default: short side of the usual plate" : "default: the wheel's own width");
  } else if (width.as_text() == "wheel") {
    p.reference_width = 0;
  } else {
    p.reference_width = width.as_quantity("mm", {0, 10, true, false});
  }
  node.finish();
  if (node.present() && node.errors() == before) check_modulus(node, p);
  return p;
}

ShearLaw load_shear(const ConfigNode& node) {
  ShearLaw s;
  const std::string type = node.choice("type", {"A", "B", "C"});
  s.type = type == "A" ? ShearLaw::Type::A : type == "B" ? ShearLaw::Type::B : ShearLaw::Type::C;
  s.cohesion = node.quantity("cohesion", "kPa", Range::between(0, 1e9));
  s.friction_angle = node.quantity("friction_angle", "deg", {0, pi / 2, false, true});
  const Range displacement{1e-6, 1, false, false};
  if (type == "A")
    s.K = node.quantity("K", "mm", displacement);
  else
    s.Kw = node.quantity("Kw", "mm", displacement);
  if (type == "C") s.Kr = node.quantity("Kr", "1", Range::between(0, 1));
  const auto only = [&](const char* key, const char* types) {
    if (node.has(key)) node.error_at(key, "belongs to shear type " + std::string(types) + ", not to type " + type);
  };
  if (type == "A")
    only("Kw", "B or C");
  else
    only("K", "A");
  if (type != "C") only("Kr", "C");
  node.finish();
  return s;
}

ContactAngles load_angles(const ConfigNode& bekker) {
  ContactAngles a;
  const ConfigNode node = bekker.optional_map("contact_angles");
  if (!node.present()) {
    bekker.assume("contact_angles", "a0 = 0.18, a1 = 0.32, b0 = 0, b1 = 0",
                  "default: literature values for loose sand (dissertation Table 4.6)");
    return a;
  }
  const Range share = Range::between(0, 1);
  a.a0 = node.quantity("a0", "1", share);
  a.a1 = node.quantity("a1", "1", Range::between(-1, 1));
  if (a.a0 + a.a1 < 0) node.error_at("a1", "a0 + a1 is negative: theta_m would lie behind the exit at full slip");
  a.b0 = node.quantity_or("b0", 0, "1", share);
  a.b1 = node.quantity_or("b1", 0, "1", share);
  node.finish();
  return a;
}

BekkerSoil load_bekker(const ConfigNode& node) {
  BekkerSoil b;
  b.pressure = load_pressure(node.map("pressure"));
  b.shear = load_shear(node.map("shear"));
  b.angles = load_angles(node);
  if (const ConfigNode r = node.optional_map("repetitive"); r.present()) {
    b.repetitive = RepetitiveLoading{r.quantity("ko", "kN/m^3", Range::between(0, 1e15)),
                                     r.quantity("Au", "kN/m^4", Range::between(0, 1e18))};
    if (b.repetitive->ko == 0 && b.repetitive->Au == 0)
      r.error("ko and Au are both 0: the soil would unload without stiffness");
    r.finish();
  }
  node.finish();
  return b;
}

RigidSoil load_rigid(const ConfigNode& node) {
  RigidSoil r;
  r.stiffness = node.quantity_or("stiffness", r.stiffness, "N/m", {0, 1e12, true, false});
  r.damping = node.quantity_or("damping", r.damping, "N s/m", Range::between(0, 1e12));
  r.friction = node.quantity_or("friction", r.friction, "1", Range::between(0, 5));
  r.rolling_resistance = node.quantity_or("rolling_resistance", r.rolling_resistance, "1", Range::between(0, 1));
  r.tangential_stiffness =
      node.quantity_or("tangential_stiffness", r.tangential_stiffness, "N/m", Range::between(0, 1e12));
  node.finish();
  return r;
}

}  // namespace

Soil load_soil(const ConfigNode& root) {
  Soil soil;
  soil.name = root.text("soil");
  soil.source = root.text("source");
  if (const ConfigNode b = root.optional_map("bekker"); b.present()) soil.bekker = load_bekker(b);
  if (const ConfigNode r = root.optional_map("rigid"); r.present()) soil.rigid = load_rigid(r);
  soil.dem = root.optional_map("dem");
  soil.bulk_density = root.quantity_or("bulk_density", 0, "kg/m^3", {0, 2e4, true, false});
  if (root.is_map() && !root.has("bekker") && !root.has("rigid") && !root.has("dem"))
    root.error("the soil has no model parameters; give a section 'bekker:', 'rigid:' or 'dem:'");
  root.finish();
  return soil;
}

Soil load_soil_file(const std::filesystem::path& file) {
  const ConfigDocument document = ConfigDocument::from_file(file);
  const Soil soil = load_soil(document.root());
  document.check();
  return soil;
}

}  // namespace grouser
