#include "dem_bed.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "grouser/dem/soil_config.h"
#include "grouser/terrain/loaders.h"

namespace grouser::app {

DemBedCase read_dem_bed(const std::filesystem::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  DemBedCase c;
  c.title = root.text("bed");
  root.text_or("source", "");
  c.soil = dem::read_soil(root.map("soil"));
  dem::read_solver(root.optional_map("solver"), c.soil);
  c.soil.seed = static_cast<unsigned>(root.integer_or("seed", 1, 0, 4294967295L));
  const ConfigNode p = root.map("pour");
  const std::vector<double> base = p.quantities("base", "m", 2, Range::positive());
  if (base.size() == 2) c.pouring.lx = base[0], c.pouring.ly = base[1];
  if (base.size() == 2 && std::min(base[0], base[1]) <= 2 * c.soil.largest)
    p.error_at("base", "the base must be wider than two of the largest grains");
  c.pouring.height = p.quantity("height", "m", Range::positive());
  c.pouring.walls = p.boolean_or("walls", false);
  c.pouring.slab = p.boolean_or("slab", false);
  if (c.pouring.walls && c.pouring.slab)
    p.error_at("slab", "walls stand on all sides, or square to y only: give one of walls and slab");
  c.pouring.compaction = p.quantity_or("compaction", 0, "Pa", Range::non_negative());
  if (c.pouring.walls && !(c.soil.bulk_density > 0))
    root.error_at("soil", "a box is filled by mass: give bulk_density");
  p.finish();
  if (root.has("tiles")) {
    const std::vector<double> n = root.quantities("tiles", "1", 2, Range::between(1, 10000));
    if (n.size() == 2) c.nx = static_cast<int>(n[0]), c.ny = static_cast<int>(n[1]);
    for (double x : n)
      if (x != std::floor(x)) root.error_at("tiles", "tiles are whole numbers: [8, 3]");
    if (c.pouring.walls) root.error_at("tiles", "grains poured into a box cannot be repeated; leave walls out");
    if (c.pouring.slab && c.ny > 1) root.error_at("tiles", "a slab between walls is repeated along x only: [8, 1]");
  }
  std::string surface_text;
  if (root.has("surface")) {
    c.surface = load_ground(root.node("surface"), c.soil.seed);
    surface_text = c.surface ? c.surface->describe() : "";
  }
  const ConfigNode f = root.optional_map("frozen");
  if (f.present()) {
    c.border = f.quantity_or("border", 0, "m", Range::non_negative());
    c.bottom = f.quantity_or("bottom", 0, "m", Range::non_negative());
    f.finish();
  }
  c.relax = root.quantity_or("relax", 0, "s", Range::non_negative());
  root.finish();
  doc.check();
  c.inputs = dem::inputs_text(c.soil) + dem::inputs_text(c.pouring) +
             fmt::format("tiles {} {}\nsurface {}\nfrozen_border_m {:.17g}\nfrozen_bottom_m {:.17g}\nrelax_s {:.17g}\n",
                         c.nx, c.ny, surface_text, c.border, c.bottom, c.relax);
  return c;
}

dem::Packing make_bed(const DemBedCase& c, const std::filesystem::path& checkpoint, double every,
                      const std::function<void(const std::string&, double)>& progress) {
  dem::Packing p =
      dem::pour(c.soil, c.pouring, checkpoint, every, [&](double done, double) { progress("pouring", done); });
  if (c.nx > 1 || c.ny > 1) p = dem::tile(p, c.nx, c.ny);
  if (c.surface) dem::cut_surface(p, [&](double x, double y) { return c.surface->height(x, y); });
  if (c.border > 0 || c.bottom > 0) dem::freeze_edges(p, c.border, c.bottom);
  if (c.relax > 0) dem::relax(p, c.soil, c.relax, [&](double done, double) { progress("coming to rest", done); });
  p.inputs = c.inputs;
  return p;
}

}  // namespace grouser::app
