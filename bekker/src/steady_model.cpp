#include <stdexcept>

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
)";

SteadyOptions read(const ConfigNode& o) {
  SteadyOptions s;
  s.bounce_damping = 0.15;
  if (!o.present()) return s;
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
  o.finish();
  return s;
}

class Steady final : public Terrain {
 public:
  Steady(const BekkerSoil& soil, const SteadyOptions& options, GroundPtr ground)
      : Terrain(std::move(ground)), soil_(soil), options_(options) {
    declare_effect({"vertical_damping", "pressure grows with the rate of sinkage, sigma (1 + chi h'), never tensile",
                    "s/m", 0, 10, 0, "Hunt & Crossley 1975"});
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
    wheels_.emplace_back(soil_, size, b.gear.radius(), options_);
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      SteadyWheel& wheel = wheels_[i];
      const WheelMotion m = wheel_motion(bodies()[i], motions[i], wheel.size().outer_radius(), wheel.size().width);
      wheel.advance(m, ground(), effects_, c.dt, results[i]);
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

  void do_set_effect(std::size_t, double amplitude) override { effects_.vertical_damping = amplitude; }

  void do_traverse(State& s) override {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      wheels_[i].traverse(s);
    }
  }

  BekkerSoil soil_;
  SteadyOptions options_;
  SteadyEffects effects_;
  std::vector<SteadyWheel> wheels_;
};

}  // namespace

ModelInfo steady_model() {
  return {
      "bekker.steady",
      "steady Bekker-Wong wheel by quadrature or closed form, with stick at rest",
      "sinkage, drawbar pull, torque and side force of smooth and lugged wheels on any ground shape; parks on slopes; "
      "reverses",
      "no soil memory (ruts, multi-pass); lugs as mean pressure of tips and tread, not one by one; no bulldozing; "
      "cylinders "
      "only",
      kDefaults,
      [](const TerrainArgs& a) -> std::unique_ptr<Terrain> {
        SteadyOptions options = read(a.options);
        options.gravity = a.gravity;
        if (!a.soil.bekker)
          throw std::invalid_argument("soil '" + a.soil.name +
                                      "' has no 'bekker:' section, which model bekker.steady needs");
        return std::make_unique<Steady>(*a.soil.bekker, options, a.ground);
      }};
}

}  // namespace grouser::bekker
