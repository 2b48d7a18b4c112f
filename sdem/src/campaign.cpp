// Campaign from YAML, its plan, its cost.
#include "grouser/sdem/campaign.h"

#include <cmath>
#include <cstdio>

#include "grouser/dem/soil_config.h"
#include "grouser/terrain/loaders.h"
#include "soil_text.h"

namespace grouser::sdem {

namespace {

constexpr int kPeriodicGrains = 6;  ///< least width of a slab without walls, in largest grains (as dem.sphere)

void put(std::string& text, const char* name, double value) {
  char line[80];
  std::snprintf(line, sizeof line, "%s %.17g\n", name, value);
  text += line;
}

bool ascending(const std::vector<double>& x) {
  for (std::size_t i = 1; i < x.size(); ++i)
    if (x[i] <= x[i - 1]) return false;
  return true;
}

}  // namespace

Campaign load_campaign(const std::filesystem::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  Campaign c;
  c.title = root.text("surrogate");
  c.source = root.text_or("source", "");
  if (const auto wheel = root.existing_file("wheel"); std::filesystem::is_regular_file(wheel)) try {
      const RunningGear gear = load_running_gear_file(wheel);
      c.wheel = gear.name;
      c.radius = gear.radius();
      if (!std::holds_alternative<SmoothCylinder>(gear.shape))
        root.error_at("wheel", "'" + gear.name + "' is no smooth cylinder, and tables of the plane know no lugs");
    } catch (const ConfigError& e) {
      for (const Diagnostic& d : e.diagnostics()) root.report(d);
    }
  c.soil = dem::read_soil(root.map("soil"));
  dem::read_solver(root.optional_map("solver"), c.soil);
  c.soil.seed = static_cast<unsigned>(root.integer_or("seed", 1, 0, 4294967295L));
  dem::set_step(c.soil);

  const ConfigNode v = root.map("velocities");
  c.w = v.quantities("spin", "rad/s", 0, Range::non_negative());
  c.vx = v.quantities("forward", "m/s", 0, Range::non_negative());
  c.vz = v.quantities("upward", "m/s");
  for (const auto& [key, nodes] : {std::pair{"spin", &c.w}, {"forward", &c.vx}, {"upward", &c.vz}})
    if (!ascending(*nodes)) v.error_at(key, "nodes must ascend");
  for (const double z : c.vz)
    if (z == 0) v.error_at("upward", "a wheel that moves neither up nor down never leaves its height: give no 0");
  v.finish();

  const ConfigNode b = root.map("bed");
  c.width = b.quantity("width", "m", Range::positive());
  c.bed_depth = b.quantity("depth", "m", Range::positive());
  c.floor_distance = b.quantity("floor_distance", "m", Range::positive());
  c.clearance = b.quantity("clearance", "m", Range::non_negative());
  c.margin = b.quantity("length", "m", Range::positive());
  c.brick = b.quantity("brick", "m", Range::positive());
  c.periodic = b.choice_or("sides", "walls", {"walls", "periodic"}) == "periodic";
  c.rough_floor = b.choice_or("floor", "smooth", {"smooth", "grains"}) == "grains";
  if (c.rough_floor && c.floor_distance > 0 && c.floor_distance <= c.soil.largest)
    b.error_at("floor_distance", "must be more than the layer of grains that stand still, one of the largest");
  const int grains = c.periodic ? kPeriodicGrains : 2;
  if (c.width > 0 && (c.periodic ? c.width < grains * c.soil.largest : c.width <= 2 * c.soil.largest))
    b.error_at("width", c.periodic ? "a slab without walls must be six of the largest grains wide at least"
                                   : "the slab must be wider than two of the largest grains");
  if (c.brick > 0 && c.brick <= 2 * c.soil.largest)
    b.error_at("brick", "a brick must be longer than two of the largest grains");
  b.finish();

  const ConfigNode a = root.optional_map("averages");
  if (a.present()) {
    c.over = a.quantity_or("over", c.over, "m", Range::positive());
    c.every = a.quantity_or("every", c.every, "m", Range::positive());
    if (c.every <= c.over) a.error_at("every", "must be longer than 'over'");
    a.finish();
  }
  const ConfigNode t = root.optional_map("tables");
  c.reach = 3 * c.radius;
  if (t.present()) {
    c.cell = t.quantity_or("cell", c.cell, "m", Range::positive());
    c.reach = t.quantity_or("reach", c.reach, "m", Range::positive());
    t.finish();
  }
  if (c.radius > 0 && c.reach <= c.radius) root.error_at("tables", "'reach' must go beyond the wheel's radius");
  if (c.margin > 0 && c.radius > 0 && c.margin < 2 * c.reach + 2 * c.soil.largest)
    b.error_at("length", "must hold the window of the tables, twice 'reach', and some");
  root.finish();
  doc.check();
  return c;
}

std::vector<CampaignRun> plan_of(const Campaign& c) {
  std::vector<CampaignRun> runs;
  for (const double w : c.w)
    for (const double vx : c.vx)
      for (const double vz : c.vz) {
        CampaignRun r;
        r.w = w;
        r.vx = vx;
        r.vz = vz;
        r.low = c.floor_distance + c.radius;
        r.high = c.bed_depth + c.clearance + c.radius;
        r.duration = (r.high - r.low) / std::abs(vz);
        r.bricks = static_cast<int>(std::ceil((c.margin + vx * r.duration) / c.brick - 1e-9));
        r.inputs = dem::inputs_text(c.soil);
        for (const auto& [name, value] : {std::pair{"w_rad_s", w},
                                          {"vx_m_s", vx},
                                          {"vz_m_s", vz},
                                          {"radius_m", c.radius},
                                          {"width_m", c.width},
                                          {"bed_depth_m", c.bed_depth},
                                          {"floor_distance_m", c.floor_distance},
                                          {"clearance_m", c.clearance},
                                          {"length_m", c.margin},
                                          {"brick_m", c.brick},
                                          {"over_m", c.over},
                                          {"every_m", c.every},
                                          {"reach_m", c.reach}})
          put(r.inputs, name, value);
        if (c.periodic) r.inputs += "sides periodic\n";
        r.inputs += c.rough_floor ? "floor grains\n" : "ends held\n";
        r.inputs += "run 2\n";
        r.name = dem::hash_text(r.inputs);
        runs.push_back(std::move(r));
      }
  return runs;
}

double grain_steps(const Campaign& c, const CampaignRun& r) {
  // Mean volume of diameters that are even by number.
  const double a = c.soil.smallest, b = c.soil.largest,
               cube = b > a ? (b * b * b * b - a * a * a * a) / (4 * (b - a)) : a * a * a;
  const double solid = c.soil.bulk_density > 0 ? c.soil.bulk_density / c.soil.density : 0.6;
  return std::min(solid, 0.6) * r.bricks * c.brick * c.width * c.bed_depth / (pi / 6 * cube) * r.duration / c.soil.dt;
}

}  // namespace grouser::sdem
