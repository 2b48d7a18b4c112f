#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "grouser/bekker/soil_node.h"
#include "grouser/terrain/loaders.h"
#include "lugs_as_mean.h"
#include "node_wheel.h"
#include "node_wong.h"
#include "reference_width.h"

namespace grouser::bekker {

namespace {

using node::Effects;
using node::NodeGrid;
using node::NodeWheel;
using node::WheelSoil;
using node::WongWheel;

constexpr const char* kDefaults = R"(# model bekker.soil_node: dynamic Bekker on soil nodes. Every key is optional.
closure: local           # local: every node's own depth and unloading; wong: theta_m map and displacement by rotation
spacing: auto            # [m] > 0 between nodes; auto: 3.3 mm, or the smallest wheel's radius / 40 where that is more
unloading_rebound: 0.02  # [1] 0.01..1 share of the plastic depth that springs back, of a soil without `repetitive`
reference_width: soil    # [m] > 0 width in the pressure law; soil: what the soil file says; wheel: the wheel's own
lugs: auto               # mean: pressure of tips and tread by their shares (eqs 2.14, 2.15), smooth in time; resolved: each lug's tip;
                         # auto: resolved where lug_width is at least 2 spacings (seen by the nodes) and 4 K (stays until shear is mobilised), else mean
theta_m_law: linear      # closure wong: linear, or wong_braking (eq 2.13 when braking)
relaxation_length: 1     # [1] 0.01..100 closure wong: rolling distance, in contact lengths, in which the shear displacement renews
rate_reference: 10 mm/s  # [m/s] > 0 speed at which the soil was tested (effects pressure_rate, shear_rate)
rate_least: 1 mm/s       # [m/s] > 0 below it the rate effects stay as they are there
regions: []              # [{x: [0 m, 2 m], y: [-1 m, 1 m], soil: other.yaml}, ...] other soils; the first that holds a node counts
strips: 3                # [1] 1..15 discs across the width, for sinkage and angles in the report
samples_per_radius: 24   # [1] 4..400 ground samples per wheel radius, for the same
)";

struct Region {
  double x0, x1, y0, y1;
  int soil;
};

struct Options {
  bool wong = false;
  double spacing = 0;    ///< 0 = auto
  SteadyOptions steady;  ///< of closure wong
  double rebound = 0.02;
  bool rebound_given = false;
  double reference_width = -1;  ///< [m]; -1 the soil's, 0 the wheel's own
  node::WheelOptions wheel;
  std::vector<Region> regions;
  std::vector<Soil> soils;  ///< of the regions
};

Options read(const ConfigNode& o) {
  Options s;
  if (!o.present()) return s;
  s.wong = o.choice_or("closure", "local", {"local", "wong"}) == "wong";
  if (o.choice_or("theta_m_law", "linear", {"linear", "wong_braking"}) == "wong_braking")
    s.steady.theta_m_law = ThetaMLaw::wong_braking;
  s.steady.relaxation_length = o.quantity_or("relaxation_length", 1, "1", Range::between(0.01, 100));
  const auto length_or_word = [&](const char* key, const char* word, double of_word, double fallback) {
    const ConfigNode n = o.node(key);
    if (!n.present()) return fallback;
    if (n.is_scalar() && n.as_text() == word) return of_word;
    return n.as_quantity("m", Range::positive());
  };
  s.spacing = length_or_word("spacing", "auto", 0, 0);
  s.rebound_given = o.has("unloading_rebound");
  s.rebound = o.quantity_or("unloading_rebound", s.rebound, "1", Range::between(0.01, 1));
  s.reference_width = read_reference_width(o);
  const std::string lugs = o.choice_or("lugs", "auto", {"auto", "mean", "resolved"});
  s.wheel.lugs = lugs == "mean" ? node::Lugs::mean : lugs == "resolved" ? node::Lugs::resolved : node::Lugs::automatic;
  s.wheel.rate_reference = o.quantity_or("rate_reference", s.wheel.rate_reference, "m/s", Range::positive());
  s.wheel.rate_least = o.quantity_or("rate_least", s.wheel.rate_least, "m/s", Range::positive());
  const std::size_t before = o.errors();
  for (const ConfigNode& r : o.optional_list("regions")) {
    const std::vector<double> x = r.quantities("x", "m", 2), y = r.quantities("y", "m", 2);
    const std::filesystem::path file = r.existing_file("soil");
    r.finish();
    if (o.errors() != before) continue;
    if (!(x[0] < x[1])) r.error_at("x", "the first value must be below the second");
    if (!(y[0] < y[1])) r.error_at("y", "the first value must be below the second");
    const ConfigDocument document = ConfigDocument::from_file(file);
    Soil soil = load_soil(document.root());
    for (const Diagnostic& d : document.diagnostics()) r.report(d);
    if (document.diagnostics().empty() && !soil.bekker)
      r.error_at("soil", "soil '" + soil.name + "' has no 'bekker:' section, which model bekker.soil_node needs");
    s.regions.push_back({x[0], x[1], y[0], y[1], static_cast<int>(s.soils.size()) + 1});
    s.soils.push_back(std::move(soil));
  }
  s.wheel.patch.strips = static_cast<int>(o.integer_or("strips", 3, 1, 15));
  s.wheel.patch.samples_per_radius = static_cast<int>(o.integer_or("samples_per_radius", 24, 4, 400));
  s.steady.patch = s.wheel.patch;
  s.steady.reference_width = s.reference_width;
  o.finish();
  return s;
}

/// A soil whose unloading slope nobody measured springs back by a default: that is an assumption of the run.
void assume_rebound(const ConfigNode& node, const Options& o, const Soil& soil) {
  if (o.rebound_given) return;
  std::vector<const Soil*> all{&soil};
  for (const Soil& s : o.soils) all.push_back(&s);
  for (const Soil* s : all) {
    if (s->bekker->repetitive) continue;
    node.assume("unloading_rebound", "0.02", "soil '" + s->name + "' has no measured unloading slope (`repetitive`)");
    return;
  }
}

SoilLaw law_of(const Soil& soil, double width, const Options& o) {
  BekkerSoil b = *soil.bekker;
  if (o.reference_width >= 0) b.pressure.reference_width = o.reference_width;
  return SoilLaw::of(b, width, o.steady.theta_m_law);
}

WheelSoil resolve(const Soil& soil, double width, const Options& o) {
  const BekkerSoil& b = *soil.bekker;
  const SoilLaw law = law_of(soil, width, o);
  WheelSoil w;
  node::Material& m = w.material;
  m.modulus = law.modulus;
  m.n = law.n;
  const bool measured = b.repetitive.has_value();
  m.ko = measured ? b.repetitive->ko : 0;
  m.Au = measured ? b.repetitive->Au : 0;
  // Below (n + 1)/2 times the secant a node would give back more than was put in, below the secant it would rise above the ground.
  const double passive = std::max(1.0, 0.5 * (law.n + 1));
  m.ratio = measured ? passive : std::max(passive, 1 / o.rebound);
  m.cohesion = law.shear.cohesion;
  m.tan_phi = law.tan_phi;
  m.K = law.shear_displacement();
  constexpr double euler = 2.718281828459045;
  switch (law.shear.type) {
    case ShearLaw::Type::A:
      m.shear_type = 0;
      m.K0 = m.K;
      break;
    case ShearLaw::Type::B:
      m.shear_type = 1;
      m.K0 = m.K / euler;
      break;
    case ShearLaw::Type::C:
      m.shear_type = 2;
      m.K0 = m.K / (law.shear.Kr + euler * (1 / (1 - 1 / euler) - law.shear.Kr));
      break;
  }
  m.residual = law.shear.Kr;
  const double reference = o.reference_width >= 0 ? o.reference_width : b.pressure.reference_width;
  w.reference_width = reference > 0 ? reference : width;
  w.density = soil.bulk_density;
  return w;
}

class SoilNode final : public Terrain {
 public:
  SoilNode(const Soil& soil, Options options, GroundPtr ground)
      : Terrain(ground), options_(std::move(options)), grid_(ground, soil_map()) {
    soils_.push_back(soil);
    soils_.insert(soils_.end(), options_.soils.begin(), options_.soils.end());
    declare_effect({"soil_damping", "pressure grows with the rate of sinkage, p (1 + chi z'), never tensile", "s/m", 0,
                    10, 0, "Hunt & Crossley 1975"});
    if (options_.wong) return;  // the others act on the local closure's own stresses
    for (const Effect id : Effects::ids) {
      const EffectInfo& e = effect_table()[static_cast<std::size_t>(id)];
      declare_effect({std::string(e.name), std::string(e.says),
                      e.inverse ? "1/" + std::string(e.unit) : std::string(e.unit), e.lower, e.upper, e.off,
                      std::string(e.source)});
    }
  }
  std::string id() const override { return "bekker.soil_node"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.memory = true;
    c.lugs = true;
    return c;
  }
  std::optional<SimplifiedGear> simplified_gear(int body) const override {
    if (options_.wong) return std::nullopt;  // smooth cylinders only
    const auto i = static_cast<std::size_t>(body);
    if (!wheels_.at(i).footprint().shape().takes_mean(spacing())) return std::nullopt;
    const auto& lugged = std::get<LuggedCylinder>(bodies()[i].gear.shape);
    return lugs_as_mean(lugged, options_.wheel.lugs == node::Lugs::mean
                                    ? "option 'lugs: mean' of model bekker.soil_node"
                                    : "the lugs are narrower than 2 node spacings or 4 shear displacements K "
                                      "(model bekker.soil_node, option 'lugs: auto')");
  }
  std::vector<FieldInfo> fields() const override {
    return {{"sinkage", "m", "depth of the soil's surface below the undisturbed ground"},
            {"plastic_depth", "m", "largest depth to which a node was pressed"},
            {"pressure", "Pa", "largest pressure that a node has borne"},
            {"shear_displacement", "m", "elastic shear displacement under the gear"}};
  }
  double field(const std::string& name, double x, double y) const override {
    if (name == "sinkage") return grid_.rut(x, y);
    if (name == "plastic_depth") return grid_.value(node::kZu, x, y);
    if (name == "pressure")
      return grid_.value(node::kKu, x, y) * (grid_.value(node::kZu, x, y) - grid_.value(node::kZs, x, y));
    if (name == "shear_displacement") return std::hypot(grid_.value(node::kU1, x, y), grid_.value(node::kU2, x, y));
    return Terrain::field(name, x, y);
  }

 private:
  std::function<int(double, double)> soil_map() const {
    if (options_.regions.empty()) return {};
    return [regions = options_.regions](double x, double y) {
      for (const Region& r : regions)
        if (x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1) return r.soil;
      return 0;
    };
  }

  void do_add_body(const BodySpec& b) override {
    std::vector<WheelSoil> soils;
    for (const Soil& s : soils_) soils.push_back(resolve(s, b.gear.width(), options_));
    smallest_ = std::min(smallest_, b.gear.outer_radius());
    if (!options_.wong) {
      wheels_.emplace_back(b, std::move(soils), options_.wheel);
      return;
    }
    if (!std::holds_alternative<SmoothCylinder>(b.gear.shape))
      throw TerrainError("bekker.soil_node cannot carry body '" + b.name + "' with closure wong: its running gear '" +
                         b.gear.name +
                         "' is no smooth cylinder, which the theta_m map needs; closure local carries any gear");
    std::vector<SoilLaw> laws;
    for (const Soil& s : soils_) laws.push_back(law_of(s, b.gear.width(), options_));
    wong_.emplace_back(
        b, std::move(soils), std::move(laws),
        SteadyWheel(*soils_.front().bekker, {b.gear.radius(), b.gear.width()}, b.gear.radius(), options_.steady));
  }

  double spacing() const { return options_.spacing > 0 ? options_.spacing : std::max(3.3e-3, smallest_ / 40); }

  /// The grid starts under the first wheel and runs along its heading, so that the answer does not know where north is.
  void lay_out(const BodyMotion& motion) {
    const node::Layout layout = [&] {
      const BodySpec& b = bodies().front();
      const WheelMotion m = wheel_motion(b, motion, b.gear.outer_radius(), b.gear.width());
      node::Layout l;
      l.origin = {m.pose.hub_W.x(), m.pose.hub_W.y()};
      l.heading = std::atan2(m.carrier(1, 0), m.carrier(0, 0));
      l.spacing = spacing();
      return l;
    }();
    grid_.lay_out(layout);
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    if (motions.empty()) return;
    if (!grid_.laid_out()) lay_out(motions[0]);
    const int n = static_cast<int>(motions.size());
    for (int i = 0; i < n; ++i) footprint(i).prepare(bodies()[i], motions[i], grid_, c.commit);
    // Wheels that share nodes follow one another; the rest may run side by side.
    group(n);
    parallel_for(static_cast<int>(groups_.size()), [&](int k) {
      for (const int i : groups_[k])
        if (options_.wong)
          wong_[i].advance(ground(), {effects_.soil_damping}, c.dt, c.commit, results[i]);
        else
          wheels_[i].advance(ground(), effects_, c.dt, c.commit, results[i]);
    });
    if (!c.commit) return;
    double stored = 0;
    for (const NodeWheel& w : wheels_) {  // in the order of the bodies, whatever the threads did
      stored += w.state().stored;
      ledger().dissipated += w.dissipated();
      ledger().integration += w.integration();
      ledger().external += w.placed();
    }
    for (const WongWheel& w : wong_) {
      stored += w.steady().state().elastic + w.steady().state().stick;
      ledger().dissipated += w.steady().spent();
      ledger().integration += w.steady().integration();
      ledger().external += w.steady().placed();
    }
    ledger().stored = stored;
    grid_.tidy();
  }

  node::Footprint& footprint(int i) { return options_.wong ? wong_[i].footprint() : wheels_[i].footprint(); }

  /// Wheels whose nodes meet, straight or through others, in one group, each in the order of the bodies.
  void group(int n) {
    std::vector<int> of(n);
    for (int i = 0; i < n; ++i) {
      of[i] = i;
      for (int j = 0; j < i; ++j) {
        if (of[j] == of[i] || footprint(i).box().empty() || !footprint(i).box().meets(footprint(j).box())) continue;
        const int from = std::max(of[i], of[j]), to = std::min(of[i], of[j]);
        std::replace(of.begin(), of.begin() + i + 1, from, to);
      }
    }
    groups_.clear();
    for (int g = 0; g < n; ++g) {
      std::vector<int> members;
      for (int i = 0; i < n; ++i)
        if (of[i] == g) members.push_back(i);
      if (!members.empty()) groups_.push_back(std::move(members));
    }
  }

  void do_preview(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    const bool first = !grid_.laid_out();
    std::vector<SteadyWheel::State> states;
    for (const WongWheel& w : wong_) states.push_back(w.steady().state());
    do_step(c, motions, results);
    for (std::size_t i = 0; i < wong_.size(); ++i) wong_[i].steady().state() = states[i];
    if (first) grid_.clear();
  }

  SurfaceSample do_surface(double x, double y) const override {
    SurfaceSample s;
    s.sinkage = grid_.rut(x, y);
    s.height = ground().height(x, y) - s.sinkage;
    s.normal = ground().normal(x, y);
    const double h = grid_.layout().spacing;
    if (h > 0) {
      const double gx = (grid_.rut(x + h, y) - grid_.rut(x - h, y)) / (2 * h);
      const double gy = (grid_.rut(x, y + h) - grid_.rut(x, y - h)) / (2 * h);
      if (gx != 0 || gy != 0)
        s.normal = Vec3(s.normal.x() / s.normal.z() + gx, s.normal.y() / s.normal.z() + gy, 1).normalized();
    }
    return s;
  }
  std::vector<Cell> do_take_changed_cells() override { return grid_.take_changed_cells(); }

  void do_set_effect(std::size_t index, double amplitude) override {
    const bool weighs =
        index > 0 && (Effects::ids[index - 1] == Effect::bulldozing || Effects::ids[index - 1] == Effect::side_wall);
    if (weighs && amplitude > 0)
      for (const Soil& s : soils_)
        if (!(s.bulk_density > 0))
          throw TerrainError("effect '" + effects()[index].id +
                             "' of bekker.soil_node needs the bulk_density of soil '" + s.name + "'");
    effects_.set(index, amplitude);
  }

  void do_traverse(State& s) override {
    for (int i = 0; i < static_cast<int>(bodies().size()); ++i) {
      const auto g = s.group("wheel" + std::to_string(i));
      node::Box& box = footprint(i).last();
      s.field("i0", box.i0);
      s.field("i1", box.i1);
      s.field("j0", box.j0);
      s.field("j1", box.j1);
      if (options_.wong) {
        wong_[i].steady().traverse(s);
      } else {
        NodeWheel::State& w = wheels_[i].state();
        s.field("stored", w.stored);
        s.field("slip", w.slip);
        s.field("travel", w.travel);
      }
    }
    const auto g = s.group("grid");
    grid_.traverse(s);
  }

  Options options_;
  NodeGrid grid_;
  std::vector<Soil> soils_;
  std::vector<NodeWheel> wheels_;  ///< closure local
  std::vector<WongWheel> wong_;    ///< closure wong
  std::vector<std::vector<int>> groups_;
  Effects effects_;
  double smallest_ = INFINITY;
};

}  // namespace

ModelInfo soil_node_model() {
  return {"bekker.soil_node",
          "dynamic Bekker on soil nodes: every node remembers its depth and its shear",
          "ruts and repeated passes, rough ground, any motion, lugs and meshes, soils by place, rate and bulldozing "
          "effects; parks on slopes",
          "no flow of soil to the sides (ruts have vertical walls), soil stays below the node it was pressed in; "
          "narrow lugs as "
          "mean pressure of tips and tread (option lugs)",
          kDefaults,
          [](const TerrainArgs& a) -> std::unique_ptr<Terrain> {
            Options options = read(a.options);
            options.wheel.gravity = a.gravity;
            if (!a.soil.bekker)
              throw std::invalid_argument("soil '" + a.soil.name +
                                          "' has no 'bekker:' section, which model bekker.soil_node needs");
            for (const Soil& s : options.soils)
              if (!s.bekker) return nullptr;  // noted in the document
            assume_rebound(a.options, options, a.soil);
            return std::make_unique<SoilNode>(a.soil, std::move(options), a.ground);
          }};
}

}  // namespace grouser::bekker
