#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "grouser/bekker/steady.h"
#include "lugs_as_mean.h"
#include "reference_width.h"
#include "steady_wheel.h"

namespace grouser::bekker {

namespace {

constexpr const char* kDefaults = R"(# model bekker.steady: steady Bekker-Wong wheel. Every key is optional.
method: nonlinear        # nonlinear: quadrature; quadratic, linear: closed forms (eqs 2.17 to 2.20; 2 to 4 and 20 % in Fz)
lateral: isotropic       # isotropic: shear against the sliding (eq 2.10); anisotropic: each direction by its own travel
theta_m_law: linear      # linear: theta_m = (a0 + a1 |s|) theta_f; wong_braking: eq 2.13 when braking
reference_width: soil    # [m] > 0 width in the pressure law; soil: what the soil file says; wheel: the wheel's own
relaxation_length: 1     # [1] 0.01..100 rolling distance, in contact lengths, in which the shear displacement renews
stick_damping: 0.15      # [1] 0..2 damping ratio of a wheel's load that rocks at rest; nothing in steady rolling
bounce_damping: 0.15     # [1] 0..2 damping ratio of a wheel's load that bounces; nothing in steady rolling
points: 10               # [1] 4..96 Gauss-Legendre points per smooth piece of the arc (method nonlinear)
tolerance: 0             # [1] 0..0.1 relative; above 0 the points are doubled until the force changes by less
strips: 3                # [1] 1..15 discs across the width
samples_per_radius: 24   # [1] 4..400 ground samples per wheel radius
pass: 1                  # [1] 1..1000 which pass over the soil this is, for effects repetitive_loading and pass_strength: of all
                         # wheels, or of each by name ({rear_left: 2, rear_right: 2}; the others make the first)
order: 0                 # [1] 0..1 place of the run in its series, for effect preparation_drift
)";

/// What belongs to the model and not to the wheel's law.
struct ModelOptions {
  SteadyOptions wheel;
  int pass = 1;
  std::map<std::string, int> pass_of;  ///< by wheel
  double order = 0;
};

ModelOptions read(const ConfigNode& o) {
  ModelOptions all;
  SteadyOptions& s = all.wheel;
  s.bounce_damping = 0.15;
  if (!o.present()) return all;
  if (o.choice_or("theta_m_law", "linear", {"linear", "wong_braking"}) == "wong_braking")
    s.theta_m_law = ThetaMLaw::wong_braking;
  const std::string method = o.choice_or("method", "nonlinear", {"nonlinear", "quadratic", "linear"});
  s.method = method == "nonlinear" ? Method::nonlinear : method == "quadratic" ? Method::quadratic : Method::linear;
  if (o.choice_or("lateral", "isotropic", {"isotropic", "anisotropic"}) == "anisotropic")
    s.lateral = Lateral::anisotropic;
  s.reference_width = read_reference_width(o);
  s.relaxation_length = o.quantity_or("relaxation_length", 1, "1", Range::between(0.01, 100));
  s.stick_damping = o.quantity_or("stick_damping", s.stick_damping, "1", Range::between(0, 2));
  s.bounce_damping = o.quantity_or("bounce_damping", s.bounce_damping, "1", Range::between(0, 2));
  s.quadrature.points = static_cast<int>(o.integer_or("points", 10, 4, 96));
  s.quadrature.tolerance = o.quantity_or("tolerance", 0, "1", Range::between(0, 0.1));
  s.patch.strips = static_cast<int>(o.integer_or("strips", 3, 1, 15));
  s.patch.samples_per_radius = static_cast<int>(o.integer_or("samples_per_radius", 24, 4, 400));
  if (const ConfigNode n = o.node("pass"); n.is_map())
    for (const std::string& wheel : n.keys()) all.pass_of[wheel] = static_cast<int>(n.integer(wheel, 1, 1000));
  else
    all.pass = static_cast<int>(o.integer_or("pass", 1, 1, 1000));
  all.order = o.quantity_or("order", 0, "1", Range::between(0, 1));
  o.finish();
  return all;
}

class Steady final : public Terrain {
 public:
  Steady(const Soil& soil, const ModelOptions& options, GroundPtr ground)
      : Terrain(std::move(ground)), name_(soil.name), soil_(*soil.bekker), options_(options) {
    constants_.density = soil.bulk_density;
    constants_.gravity = options.wheel.gravity;
    declare_effect({"vertical_damping", "pressure grows with the rate of sinkage, sigma (1 + chi h'), never tensile",
                    "s/m", 0, 10, 0, "Hunt & Crossley 1975"});
    for (const EffectInfo& e : effect_table())
      declare_effect({std::string(e.name), std::string(e.says),
                      e.inverse ? "1/" + std::string(e.unit) : std::string(e.unit), e.lower, e.upper, e.off,
                      std::string(e.source)});
  }
  std::string id() const override { return "bekker.steady"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.lugs = true;  // their mean pressure; single lugs and the soil between them are not
    return c;
  }

  std::optional<SimplifiedGear> simplified_gear(int body) const override {
    const auto* lugged = std::get_if<LuggedCylinder>(&bodies().at(static_cast<std::size_t>(body)).gear.shape);
    if (!lugged) return std::nullopt;
    return lugs_as_mean(*lugged, "model bekker.steady does not take lugs one by one");
  }

 private:
  void do_add_body(const BodySpec& b) override {
    if (std::holds_alternative<TriangleMesh>(b.gear.shape))
      throw TerrainError("bekker.steady cannot carry body '" + b.name + "': its running gear '" + b.gear.name +
                         "' is a triangle mesh, and the law needs a cylinder (shape: smooth or lugged)");
    WheelSize size{b.gear.radius(), b.gear.width()};
    if (const auto* lugged = std::get_if<LuggedCylinder>(&b.gear.shape)) {
      size.lug_height = lugged->lug_height;
      size.lug_ratio = lugged->lug_ratio;
    }
    SteadyWheel wheel(soil_, size, b.gear.radius(), options_.wheel);
    check_wheel(b);
    const auto named = options_.pass_of.find(b.name);
    ArcEffects arc(constants_, size.outer_radius(), wheel.reference_width(),
                   named == options_.pass_of.end() ? options_.pass : named->second, options_.order);
    for (std::size_t i = 0; i < effect_count; ++i) arc.set(effect_table()[i].id, effects()[i + 1].amplitude);
    wheel.set_effects(arc);
    arcs_.push_back(std::move(arc));
    wheels_.push_back(std::move(wheel));
  }

  void check_wheel(const BodySpec& b) const {
    if (effects()[1 + static_cast<std::size_t>(Effect::lugs)].amplitude != 0 && b.gear.outer_radius() > b.gear.radius())
      throw TerrainError("effect 'lugs' of bekker.steady is for a wheel that is carried as smooth; wheel '" + b.name +
                         "' has lugs of its own, which the law takes already");
  }
  /// Names of wheels in option `pass` can be checked when all wheels are known.
  void check_passes() {
    if (std::exchange(passes_checked_, true)) return;
    for (const auto& [name, pass] : options_.pass_of)
      if (std::none_of(bodies().begin(), bodies().end(), [&](const BodySpec& b) { return b.name == name; }))
        throw TerrainError("option 'pass' of bekker.steady names a wheel '" + name +
                           "', which there is not; wheels: " + wheel_names());
  }
  std::string wheel_names() const {
    std::string all;
    for (const BodySpec& b : bodies()) all += (all.empty() ? "" : ", ") + b.name;
    return all;
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    if (!options_.pass_of.empty()) check_passes();
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      SteadyWheel& wheel = wheels_[i];
      const WheelMotion m = wheel_motion(bodies()[i], motions[i], wheel.size().outer_radius(), wheel.size().width);
      wheel.advance(m, ground(), damping_, c.dt, results[i]);
    });
    double stored = 0;
    for (const SteadyWheel& w : wheels_) {  // in the order of the bodies, whatever the threads did
      stored += w.state().elastic + w.state().stick;
      ledger().dissipated += w.spent();
      ledger().integration += w.integration();
      ledger().external += w.placed();
    }
    ledger().stored = stored;
  }

  void do_preview(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    std::vector<SteadyWheel::State> states;
    for (const SteadyWheel& w : wheels_) states.push_back(w.state());
    const EnergyLedger before = energy();
    do_step(c, motions, results);
    for (std::size_t i = 0; i < wheels_.size(); ++i) wheels_[i].state() = states[i];
    ledger() = before;
  }

  void do_set_effect(std::size_t index, double amplitude) override {
    if (index == 0) {
      damping_.vertical_damping = amplitude;
      return;
    }
    const EffectInfo& e = effect_table()[index - 1];
    if (amplitude != e.off) check_effect(e, amplitude);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      arcs_[i].set(e.id, amplitude);
      wheels_[i].set_effects(arcs_[i]);
      check_wheel(bodies()[i]);
    }
  }

  void check_effect(const EffectInfo& e, double amplitude) const {
    const std::string name = "effect '" + std::string(e.name) + "' of bekker.steady ";
    if (options_.wheel.method != Method::nonlinear)
      throw TerrainError(name + "needs 'method: nonlinear': the closed forms know the plain law only");
    if ((e.id == Effect::bulldozing || e.id == Effect::side_wall) && !(constants_.density > 0))
      throw TerrainError(name + "needs the bulk_density of soil '" + name_ + "'");
    const double rest = soil_.angles.b0 + soil_.angles.b1;
    if (e.id == Effect::exit_angle && amplitude + rest > 1)
      throw TerrainError(name + "and the soil's own b0 + b1 may be 1 at most together");
  }

  void do_traverse(State& s) override {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      wheels_[i].traverse(s);
    }
  }

  std::string name_;
  BekkerSoil soil_;
  ModelOptions options_;
  EffectConstants constants_;
  SteadyEffects damping_;
  bool passes_checked_ = false;
  std::vector<ArcEffects> arcs_;  ///< of each wheel
  std::vector<SteadyWheel> wheels_;
};

}  // namespace

ModelInfo steady_model() {
  return {
      "bekker.steady",
      "steady Bekker-Wong wheel by quadrature or closed form, with stick at rest",
      "sinkage, drawbar pull, torque and side force of smooth and lugged wheels on any ground shape; parks on slopes; "
      "reverses",
      "no soil memory (ruts, multi-pass); lugs as mean pressure of tips and tread, not one by one; cylinders only",
      kDefaults,
      [](const TerrainArgs& a) -> std::unique_ptr<Terrain> {
        ModelOptions options = read(a.options);
        options.wheel.gravity = a.gravity;
        if (!a.soil.bekker)
          throw std::invalid_argument("soil '" + a.soil.name +
                                      "' has no 'bekker:' section, which model bekker.steady needs");
        return std::make_unique<Steady>(a.soil, options, a.ground);
      }};
}

}  // namespace grouser::bekker
