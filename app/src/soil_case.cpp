#include "soil_case.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "grouser/dem/soil_config.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;

/// Everything that a variant may change.
struct Plan {
  std::string variant;
  dem::SoilSettings soil;
  ConfigNode packing;  ///< of the file or the variant
  std::vector<unsigned> seeds;
  dem::ShearSettings shear;
  std::vector<double> pressures, rates;
  dem::SinkageSettings sinkage;
  dem::ReposeSettings repose;
  dem::OedometerSettings oedometer;
  dem::TriaxialSettings triaxial;
};

double length(const ConfigNode& n, const char* key, double now, bool partial) {
  return partial ? n.quantity_or(key, now, "m", Range::positive()) : n.quantity(key, "m", Range::positive());
}

void read_shear(const ConfigNode& n, Plan& p, bool partial) {
  dem::ShearSettings& s = p.shear;
  s.side = length(n, "side", s.side, partial);
  s.height = length(n, "height", s.height, partial);
  s.displacement = length(n, "displacement", s.displacement, partial);
  s.rest = n.quantity_or("rest", s.rest, "s", Range::non_negative());
  s.rest_speed = n.quantity_or("rest_speed", s.rest_speed, "m/s", Range::non_negative());
  s.samples = static_cast<int>(n.integer_or("samples", s.samples, 2, 100000));
  if (!partial || n.has("pressures")) p.pressures = n.quantities("pressures", "Pa", 0, Range::positive());
  if (!partial || n.has("rates")) p.rates = n.quantities("rates", "m/s", 0, Range::positive());
  if (s.side <= 2 * p.soil.largest) n.error_at("side", "the box must be wider than two of the largest grains");
  n.finish();
}

void read_sinkage(const ConfigNode& n, Plan& p, bool partial) {
  dem::SinkageSettings& s = p.sinkage;
  if (!partial || n.has("bin")) {
    const std::vector<double> b = n.quantities("bin", "m", 2, Range::positive());
    if (b.size() == 2) s.bin_x = b[0], s.bin_y = b[1];
  }
  if (!partial || n.has("plate")) {
    const std::vector<double> b = n.quantities("plate", "m", 3, Range::positive());
    if (b.size() == 3) s.plate_x = b[0], s.plate_y = b[1], s.plate_z = b[2];
  }
  s.depth = length(n, "depth", s.depth, partial);
  s.sinkage = length(n, "sinkage", s.sinkage, partial);
  s.brick = length(n, "brick", s.brick, partial);
  s.samples = static_cast<int>(n.integer_or("samples", s.samples, 2, 100000));
  if (!partial || n.has("rates")) p.rates = n.quantities("rates", "m/s", 0, Range::positive());
  for (const auto& [key, bin, plate] :
       {std::tuple{"length", s.bin_x, s.plate_x}, std::tuple{"width", s.bin_y, s.plate_y}}) {
    const double bricks = bin / s.brick;
    if (std::abs(bricks - std::round(bricks)) > 1e-6 || bricks < 0.5)
      n.error_at("bin", fmt::format("its {} must be a whole number of bricks of {:g} mm", key, 1e3 * s.brick));
    if (plate >= bin) n.error_at("plate", fmt::format("its {} must be less than the bin's", key));
  }
  if (s.depth <= s.sinkage) n.error_at("depth", "the soil must be deeper than the sinkage");
  if (s.brick <= 2 * p.soil.largest) n.error_at("brick", "a brick must be wider than two of the largest grains");
  n.finish();
}

void read_repose(const ConfigNode& n, Plan& p, bool partial) {
  dem::ReposeSettings& s = p.repose;
  if (!partial || n.has("base")) {
    const std::vector<double> b = n.quantities("base", "m", 2, Range::positive());
    if (b.size() == 2) s.base_x = b[0], s.base_y = b[1];
    if (b.size() == 2 && std::min(b[0], b[1]) <= 2 * p.soil.largest)
      n.error_at("base", "the box must be wider than two of the largest grains");
  }
  s.height = length(n, "height", s.height, partial);
  s.lift = n.quantity_or("lift", s.lift, "m/s", Range::positive());
  s.duration = n.quantity_or("duration", s.duration, "s", Range::positive());
  s.samples = static_cast<int>(n.integer_or("samples", s.samples, 2, 100000));
  n.finish();
}

void read_oedometer(const ConfigNode& n, Plan& p, bool partial) {
  dem::OedometerSettings& s = p.oedometer;
  s.side = length(n, "side", s.side, partial);
  s.height = length(n, "height", s.height, partial);
  if (!partial || n.has("pressures")) s.pressures = n.quantities("pressures", "Pa", 0, Range::positive());
  s.hold = n.quantity_or("hold", s.hold, "s", Range::positive());
  s.rest_speed = n.quantity_or("rest_speed", s.rest_speed, "m/s", Range::non_negative());
  if (s.side <= 2 * p.soil.largest) n.error_at("side", "the box must be wider than two of the largest grains");
  n.finish();
}

void read_triaxial(const ConfigNode& n, Plan& p, bool partial) {
  dem::TriaxialSettings& s = p.triaxial;
  s.side = length(n, "side", s.side, partial);
  s.height = length(n, "height", s.height, partial);
  if (!partial || n.has("pressures")) p.pressures = n.quantities("pressures", "Pa", 0, Range::positive());
  s.strain_rate = n.quantity_or("strain_rate", s.strain_rate, "1/s", Range::positive());
  s.strain = n.quantity_or("strain", s.strain, "1", {0, 0.5, true, false});
  s.wall_speed = n.quantity_or("wall_speed", s.wall_speed, "m/s", Range::positive());
  if (s.wall_speed < s.strain_rate * s.height)
    n.error_at(
        n.has("wall_speed") ? "wall_speed" : "strain_rate",
        fmt::format("side walls at {:.3g} m/s cannot follow a lid that moves at strain_rate x height = {:.3g} m/s",
                    s.wall_speed, s.strain_rate * s.height));
  s.rest = n.quantity_or("rest", s.rest, "s", Range::positive());
  s.rest_speed = n.quantity_or("rest_speed", s.rest_speed, "m/s", Range::non_negative());
  s.samples = static_cast<int>(n.integer_or("samples", s.samples, 2, 100000));
  if (s.side <= 2 * p.soil.largest) n.error_at("side", "the box must be wider than two of the largest grains");
  n.finish();
}

/// Name of the section of a test in the file.
std::string section_of(std::string kind) {
  std::replace(kind.begin(), kind.end(), '-', '_');
  return kind;
}

void read_seeds(const ConfigNode& root, Plan& p) {
  p.seeds.clear();
  for (const ConfigNode& n : root.list("seeds")) {
    const double x = n.as_quantity("1", Range::between(0, 4294967295.0));
    if (x != std::floor(x)) n.error("a seed is a whole number");
    p.seeds.push_back(static_cast<unsigned>(x));
  }
}

/// Letters, digits and . - of a name, for file names.
std::string slug(const std::string& name) {
  std::string out;
  for (char c : name) {
    const bool keep = std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-';
    if (keep)
      out += c;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

void add_case(SoilFile& f, const Plan& p, std::size_t packing, SoilTestSettings test, const std::string& curve) {
  const unsigned seed = p.seeds[packing];
  SoilCase c;
  c.packing = packing;
  c.variant = p.variant;
  c.curve = curve;
  c.soil = p.soil;
  c.soil.seed = seed;
  c.poured = p.packing.present() ? dem::read_soil(p.packing, &c.soil) : c.soil;
  dem::set_step(c.soil);
  dem::set_step(c.poured);
  c.test = std::move(test);
  c.group = p.variant.empty() ? curve : p.variant + ", " + curve;
  c.name = slug(c.group) + "-seed" + std::to_string(seed);
  c.inputs = dem::inputs_text(c.soil) + std::visit([](const auto& t) { return dem::inputs_text(t); }, c.test);
  // Only where it differs: other cases keep their name.
  if (p.packing.present()) c.inputs += "poured as\n" + dem::inputs_text(c.poured);
  c.hash = dem::hash_text(c.inputs);
  f.cases.push_back(std::move(c));
}

SoilReference read_reference(const ConfigNode& n, const std::string& kind) {
  SoilReference r;
  if (!n.present()) return r;
  r.source = n.text("source");
  if (kind == "direct-shear") {
    r.shear = true;
    r.c = n.quantity("cohesion", "Pa", Range::non_negative());
    r.phi = n.quantity("friction_angle", "rad", Range::between(0, 1.5));
    r.K = n.quantity("K", "m", Range::positive());
  } else if (kind != "pressure-sinkage") {
    n.error("there is no reference for this test");
  } else {
    r.sinkage = true;
    r.n = n.quantity("n", "1", Range::positive());
    r.k = n.quantity("k", "Pa", Range::positive());
    r.width = n.quantity("width", "m", Range::positive());
  }
  n.finish();
  return r;
}

}  // namespace

dem::PourSettings SoilCase::pouring() const {
  return std::visit([](const auto& t) { return dem::pour_settings(t); }, test);
}

std::unique_ptr<dem::SoilTest> SoilCase::make(const dem::Packing& bed) const {
  if (const auto* t = std::get_if<dem::ShearSettings>(&test)) return dem::make_direct_shear(soil, bed, *t);
  if (const auto* t = std::get_if<dem::SinkageSettings>(&test)) return dem::make_pressure_sinkage(soil, bed, *t);
  if (const auto* t = std::get_if<dem::ReposeSettings>(&test)) return dem::make_angle_of_repose(soil, bed, *t);
  if (const auto* t = std::get_if<dem::TriaxialSettings>(&test)) return dem::make_triaxial(soil, bed, *t);
  return dem::make_oedometer(soil, bed, std::get<dem::OedometerSettings>(test));
}

double SoilReference::shear_stress(double sigma, double j) const {
  return (c + sigma * std::tan(phi)) * (1 - std::exp(-j / K));
}
double SoilReference::pressure(double z) const { return z > 0 ? k * std::pow(z / width, n) : 0; }

SoilFile read_soil_file(const fs::path& file, const std::string& kind,
                        const std::function<void(dem::SoilSettings&)>& change) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  SoilFile out;
  out.file = file;
  out.kind = kind;
  out.title = root.text("soil_test");
  root.text_or("source", "");
  const std::string section = section_of(kind);
  for (const std::string& other : soil_test_kinds())
    if (!root.has(section) && root.has(section_of(other)))
      throw ConfigError(file.string(), root.node(section_of(other)).line(), 1,
                        "this is a test for 'grouser soil " + other + "', not '" + kind + "'");
  const auto read_test = [&](const ConfigNode& n, Plan& p, bool partial) {
    if (kind == "direct-shear")
      read_shear(n, p, partial);
    else if (kind == "pressure-sinkage")
      read_sinkage(n, p, partial);
    else if (kind == "angle-of-repose")
      read_repose(n, p, partial);
    else if (kind == "triaxial")
      read_triaxial(n, p, partial);
    else
      read_oedometer(n, p, partial);
  };
  Plan base;
  base.soil = dem::read_soil(root.map("soil"));
  dem::read_solver(root.optional_map("solver"), base.soil);
  if (change) change(base.soil);
  base.packing = root.optional_map("packing");
  if (base.packing.present()) dem::read_soil(base.packing, &base.soil);
  read_seeds(root, base);
  read_test(root.map(section), base, false);
  std::vector<Plan> plans;
  std::set<std::string> names;
  for (const ConfigNode& v : root.optional_list("variants")) {
    Plan p = base;
    p.variant = v.text("name");
    if (!names.insert(p.variant).second) v.error_at("name", "two variants are called '" + p.variant + "'");
    if (v.has("soil")) p.soil = dem::read_soil(v.map("soil"), &base.soil);
    if (change) change(p.soil);
    if (v.has("packing")) p.packing = v.map("packing");
    if (p.packing.present()) dem::read_soil(p.packing, &p.soil);
    dem::read_solver(v.optional_map("solver"), p.soil);
    if (v.has("seeds")) read_seeds(v, p);
    if (v.has(section)) read_test(v.map(section), p, true);
    v.finish();
    plans.push_back(std::move(p));
  }
  if (plans.empty()) plans.push_back(base);
  out.reference = read_reference(root.optional_map("reference"), kind);
  root.finish();
  doc.check();
  std::size_t most = 0;
  for (const Plan& p : plans) most = std::max(most, p.seeds.size());
  for (std::size_t k = 0; k < most; ++k)
    for (const Plan& p : plans) {
      if (k >= p.seeds.size()) continue;
      if (kind == "angle-of-repose") add_case(out, p, k, p.repose, "angle of repose");
      if (kind == "oedometer") add_case(out, p, k, p.oedometer, "oedometer");
      if (kind == "triaxial")
        for (double pressure : p.pressures) {
          dem::TriaxialSettings t = p.triaxial;
          t.pressure = pressure;
          add_case(out, p, k, t, fmt::format("{:g} Pa", pressure));
        }
      for (double rate : p.rates) {
        if (kind == "pressure-sinkage") {
          dem::SinkageSettings t = p.sinkage;
          t.rate = rate;
          add_case(out, p, k, t, fmt::format("{:g} mm/s", 1e3 * rate));
          continue;
        }
        for (double pressure : p.pressures) {
          dem::ShearSettings t = p.shear;
          t.pressure = pressure;
          t.rate = rate;
          add_case(out, p, k, t, fmt::format("{:g} Pa, {:g} mm/s", pressure, 1e3 * rate));
        }
      }
    }
  std::set<std::string> files;
  for (const SoilCase& c : out.cases)
    if (!files.insert(c.name).second)
      throw ConfigError(file.string(), 0, 0,
                        "two cases would be stored as '" + c.name +
                            "': give each seed, pressure and rate once and name variants apart");
  return out;
}

void check_soil_file(const fs::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  for (const std::string& kind : soil_test_kinds())
    if (doc.root().has(section_of(kind))) {
      read_soil_file(file, kind);
      return;
    }
  read_soil_file(file, soil_test_kinds()[0]);
}

SoilCampaign read_campaign(const fs::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  SoilCampaign out;
  out.title = root.text("campaign");
  std::vector<std::tuple<fs::path, std::string, std::size_t>> files;
  for (const ConfigNode& n : root.list("runs")) {
    const std::string test = n.choice("test", soil_test_kinds());
    const fs::path f = n.existing_file("file");
    files.emplace_back(f, test, static_cast<std::size_t>(n.integer_or("later", 0, 0, 1000)));
    n.finish();
  }
  root.finish();
  doc.check();
  std::set<std::string> stems;
  for (const auto& [f, test, later] : files) {
    if (!stems.insert(f.stem().string()).second)
      throw ConfigError(file.string(), 0, 0,
                        "two files are called '" + f.stem().string() + "'; results go to a folder of that name");
    out.runs.push_back({read_soil_file(f, test), later});
  }
  return out;
}

const std::vector<std::string>& soil_test_kinds() {
  static const std::vector<std::string> kinds{"direct-shear", "pressure-sinkage", "angle-of-repose", "oedometer",
                                              "triaxial"};
  return kinds;
}

}  // namespace grouser::app
