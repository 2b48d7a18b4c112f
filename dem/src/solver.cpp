#include "grouser/dem/solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bodies.h"
#include "kernel.h"
#include "law_table.h"
#include "lists.h"
#include "team.h"

namespace grouser::dem {

struct Solver::Impl {
  virtual ~Impl() = default;
  virtual int add_body(const BodySettings&) = 0;
  virtual int add_surface(int body, Shape shape, int material) = 0;
  virtual Body& body(int) = 0;
  virtual void place(int body, const Pose& X) = 0;
  virtual const Surface& surface(int) const = 0;
  virtual std::vector<BodyContact> contacts(int body) const = 0;
  virtual void step(long) = 0;
  virtual std::vector<GrainState> grains() const = 0;
  virtual double kinetic_energy() const = 0;
  virtual Vec3 momentum() const = 0;
  virtual double stable_step() const = 0;
  virtual Ledger ledger() const = 0;
  virtual Counters counters() const = 0;
  virtual void replace(const std::vector<std::size_t>&, const std::vector<GrainState>&) = 0;
  virtual void traverse(State&) = 0;
  SolverSettings set;
  double time = 0;
  const Kernel* kernel = nullptr;
};

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr long kAdaptEvery = 64;      ///< steps
constexpr std::uint32_t kLayout = 2;  ///< of what is saved: changes with the records of grains and contacts

std::string text_of(const char* format, auto... a) {
  char text[300];
  if constexpr (sizeof...(a) == 0)
    std::snprintf(text, sizeof text, "%s", format);
  else
    std::snprintf(text, sizeof text, format, a...);
  return text;
}
[[noreturn]] void refuse(const char* format, auto... a) { throw DemError(text_of(format, a...)); }
[[noreturn]] void refuse_grains(std::vector<std::size_t> numbers, const char* format, auto... a) {
  throw GrainError(text_of(format, a...), std::move(numbers));
}

template <class R>
class Engine final : public Solver::Impl {
 public:
  /// `spent` is the input when nobody needs it any more: it is freed before the lists are made.
  Engine(const SolverSettings& s, const std::vector<GrainState>& input, std::vector<GrainState>* spent)
      : space_(s.domain) {
    set = s;
    kernel = find_kernel(s.isa.c_str());
    if (!kernel)
      refuse("instruction set '%s' cannot be run here; allowed: avx512, avx2, base where the machine has them",
             s.isa.c_str());
    table_ = law_table<R>(s.materials, s.law);
    const int m = static_cast<int>(s.materials.materials.size());
    if (m < 1 || m > 5) refuse("%d materials; 1 to 5 are allowed", m);
    for (int a = 0; a < m; ++a)
      for (int b = 0; b < m; ++b) pair_type_.push_back(static_cast<std::uint8_t>(s.materials.index(a, b)));
    grains_.resize(input.size());
    ids_.reserve(input.size());
    material_.reserve(input.size());
    size_.reserve(input.size());
    for (std::size_t k = 0; k < input.size(); ++k) put(input[k], grains_[k]);
    for (std::size_t k = 0; k < input.size(); ++k) {
      largest_ = std::max(largest_, input[k].radius);
      ids_.push_back(static_cast<std::uint32_t>(k));
      material_.push_back(static_cast<std::uint8_t>(input[k].material));
      size_.push_back({input[k].radius, input[k].density});
    }
    if (spent) std::vector<GrainState>().swap(*spent);
    look_at_materials();
    lists_.ledger = set.ledger;
    lists_.prepare(space_, set.skin, grains_, ids_.size());
    Team alone(1);
    alone.together([&](int t) { sort(alone, t); });
    kinetic_before_ = kinetic_energy();
    momentum_before_ = momentum();
    const auto worst = lists_.deepest(space_, grains_, ids_);
    if (worst.share > 0.25)
      refuse_grains({worst.a, worst.b}, "grains %u and %u overlap by %.3g m, more than a quarter of the smaller radius",
                    worst.a, worst.b, worst.depth);
  }

  int add_body(const BodySettings& b) override {
    if (b.free && !(b.mass > 0 && b.inertia.minCoeff() > 0)) refuse("a free body needs a positive mass and inertia");
    walls_.bodies.push_back({b, b.X_WB, b.V_W, {}, 0});
    return static_cast<int>(walls_.bodies.size()) - 1;
  }
  int add_surface(int body_number, Shape shape, int material) override {
    Body& b = body(body_number);
    if (material < 0 || material >= static_cast<int>(set.materials.materials.size()))
      refuse("surface: material %d; there are %zu", material, set.materials.materials.size());
    if (shape.kind() == ShapeKind::plane) {
      const Vec3 n = b.X.q * shape.normal();
      for (int k = 0; k < 3; ++k)
        if (set.domain.periodic[static_cast<std::size_t>(k)] && std::fabs(n[k]) > 1e-12)
          refuse("a plane cannot lean along the periodic axis %c", "xyz"[k]);
      if (b.V.w.norm() > 0) refuse("a plane cannot turn; use a mesh");
    }
    double largest = 0;
    for (std::size_t k = 0; k < ids_.size(); ++k) largest = std::max(largest, double(grains_[k].r));
    shape.prepare(largest + kWallMargin);
    refuse_buried(shape, b, body_number, largest);
    walls_.surfaces.push_back({body_number, material, std::move(shape), {}});
    for (Chunk& c : lists_.chunks()) c.walls_due = 1;
    return static_cast<int>(walls_.surfaces.size()) - 1;
  }
  /// A body may not start in the bed.
  void refuse_buried(const Shape& shape, const Body& b, int body_number, double largest) const {
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      const Grain<R>& g = grains_[k];
      if (g.im == 0) continue;
      const Vec3 x = walls_.local(space_, g, b);
      const double r = double(g.r), d = shape.distance(x, largest);
      if (d < 0.75 * r)
        refuse_grains(
            {ids_[k]},
            "grain %u at (%.4g, %.4g, %.4g) m is %.3g m deep in surface %zu, of body %d; at most a quarter of its "
            "radius, %.3g m, is allowed at the start",
            ids_[k], space_.position(g)[0], space_.position(g)[1], space_.position(g)[2], r - d, walls_.surfaces.size(),
            body_number, 0.25 * r);
    }
  }
  Body& body(int k) override {
    if (k < 0 || k >= static_cast<int>(walls_.bodies.size())) refuse("body %d; there are %zu", k, walls_.bodies.size());
    return walls_.bodies[static_cast<std::size_t>(k)];
  }
  void place(int k, const Pose& X) override {
    body(k).X = X;
    for (Chunk& c : lists_.chunks()) c.walls_due = 1;
  }
  const Surface& surface(int k) const override {
    if (k < 0 || k >= static_cast<int>(walls_.surfaces.size()))
      refuse("surface %d; there are %zu", k, walls_.surfaces.size());
    return walls_.surfaces[static_cast<std::size_t>(k)];
  }

  std::vector<BodyContact> contacts(int body_number) const override {
    std::vector<BodyContact> out;
    walls_.each_contact(
        body_number, grains_, ids_.size(), [&](const WallBlock<R>& b, std::size_t l, double radius, std::size_t type) {
          const double delta = b.delta[l], r = radius / (1 + radius * double(b.curvature[l])), a = std::sqrt(r * delta);
          BodyContact c;
          for (int k = 0; k < 3; ++k) {
            c.at[k] = b.at[k][l];
            c.force[k] =
                a * (double(table_.kn[type]) * delta * double(b.n[k][l]) + double(table_.kt[type]) * double(b.s[k][l]));
          }
          out.push_back(c);
        });
    return out;
  }

  void step(long n) override {
    if (n <= 0) return;
    const KernelOf<R>& k = of<R>(*kernel);
    Team team(std::clamp(set.threads, 1, std::max(1, static_cast<int>(chunks().size()) / 2)));
    team.together([&](int t) {
      for (long s = 0; s < n; ++s) {
        if (sort_due_ && !sort(team, t)) return;
        team.guard([&] { sweep(team, t, s, work(), k); });
        team.first_done(t, s);  // also after a failure: somebody may be waiting
        if (!team.wait([this] { finish_step(); })) return;
      }
    });
  }

  std::vector<GrainState> grains() const override {
    std::vector<GrainState> out(ids_.size());
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      const std::uint32_t id = ids_[k];
      GrainState& o = out[id];
      const Grain<R>& g = grains_[k];
      o.radius = size_[id].radius;
      o.density = size_[id].density;
      o.material = material_[id];
      o.frozen = g.im == 0;
      o.x = space_.position(g);
      o.v = Vec3(double(g.v[0]), double(g.v[1]), double(g.v[2]));
      o.w = Vec3(double(g.w[0]), double(g.w[1]), double(g.w[2]));
    }
    return out;
  }
  double kinetic_energy() const override {
    double e = 0;
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      const Grain<R>& g = grains_[k];
      if (g.im == 0) continue;
      double v2 = 0, w2 = 0;
      for (int a = 0; a < 3; ++a) {
        v2 += double(g.v[a]) * double(g.v[a]);
        w2 += double(g.w[a]) * double(g.w[a]);
      }
      e += 0.5 * (v2 / double(g.im) + w2 / double(g.ii));
    }
    return e;
  }
  Vec3 momentum() const override {
    Vec3 p = Vec3::Zero();
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      const Grain<R>& g = grains_[k];
      if (g.im != 0) p += Vec3(double(g.v[0]), double(g.v[1]), double(g.v[2])) / double(g.im);
    }
    return p;
  }
  double stable_step() const override { return stiffest_ > 0 ? kStable / std::sqrt(stiffest_) : 1e30; }
  Ledger ledger() const override {
    if (!set.ledger) refuse("the energy ledger was not asked for (settings.ledger)");
    Ledger l = ledger_;
    for (const Body& b : walls_.bodies) l.bodies += b.given;
    return l;
  }
  Counters counters() const override {
    Counters c = counters_;
    c.grains = ids_.size();
    c.refreshes = renewed_ / chunks().size();
    c.listed = lists_.listed();
    c.candidates = lists_.candidates();
    double touching = 0;
    for (std::size_t k = 0; k < ids_.size(); ++k) touching += double(grains_[k].touching);
    c.touching = touching / 2 / static_cast<double>(ids_.size());
    c.bytes = sizeof(Grain<R>) * grains_.capacity() + sizeof(Load<R>) * loads_.capacity() + lists_.bytes() +
              walls_.bytes() + sizeof(std::uint32_t) * ids_.capacity() + material_.capacity() +
              sizeof(Size) * size_.capacity();
    return c;
  }

  void replace(const std::vector<std::size_t>& numbers, const std::vector<GrainState>& states) override {
    std::vector<std::uint32_t> place(ids_.size());
    for (std::size_t k = 0; k < ids_.size(); ++k) place[ids_[k]] = static_cast<std::uint32_t>(k);
    std::vector<std::uint8_t> marked(ids_.size(), 0);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const std::size_t n = numbers[k];
      if (n >= ids_.size()) refuse("replace: grain %zu; there are %zu", n, ids_.size());
      if (marked[place[n]]) refuse("replace: grain %zu is named twice", n);
      if (states[k].radius > largest_)
        refuse("replace: grain %zu: radius %g m is beyond the largest at the start, %g m", n, states[k].radius,
               largest_);
      marked[place[n]] = 1;
      put(states[k], grains_[place[n]]);
      size_[n] = {states[k].radius, states[k].density};
      material_[n] = static_cast<std::uint8_t>(states[k].material);
    }
    look_at_materials();
    lists_.forget(marked);
    walls_.forget(marked);
    sort_due_ = true;
  }

  void traverse(State& s) override {
    std::uint32_t layout = kLayout;
    s.field("layout", layout);
    if (layout != kLayout)
      refuse("state of layout %u; this program has %u: remove the checkpoint, or go on with the program that wrote it",
             layout, kLayout);
    s.field("time", time);
    if (set.adapt > 0) s.field("dt", set.dt);
    if (set.exchange) {
      raw(s, "sizes", size_);
      raw(s, "materials", material_);
    }
    s.field("stiffest", stiffest_);
    s.field("sort_due", sort_due_);
    s.field("surfaces_travelled", walls_.travelled);
    s.field("steps", counters_.steps);
    if (set.ledger) {
      auto g = s.group("ledger");
      double* x[] = {&ledger_.normal_spring,
                     &ledger_.tangential_spring,
                     &ledger_.rolling_spring,
                     &ledger_.normal_damping,
                     &ledger_.tangential_damping,
                     &ledger_.rolling_damping,
                     &ledger_.sliding,
                     &ledger_.rolling_slip,
                     &ledger_.tangential_change,
                     &ledger_.rolling_change,
                     &ledger_.cohesion,
                     &ledger_.kinetic,
                     &kinetic_before_,
                     &drag_before_,
                     &ledger_.drag,
                     &ledger_.gravity,
                     &ledger_.start};
      for (double* v : x) s.field("energy", *v);
      s.field("momentum", momentum_before_);
    }
    raw(s, "ids", ids_);
    raw(s, "grains", grains_);
    const auto array = [&](const char* name, auto& a) { raw(s, name, a); };
    lists_.each_array(array, s.loading());
    walls_.each_array(chunks().size(), array);
    if (s.loading()) {
      look_at_materials();
      walls_.complete(ids_.size());
      // Sums are zero between steps.
      loads_.assign(grains_.size(), Load<R>{});
      limits_.assign(chunks().size(), StepLimits{});
      energies_.assign(chunks().size(), Energies{});
    }
    const auto report = [&](SurfaceReport& r) {
      s.field("force", r.force);
      s.field("torque", r.torque);
      s.field("impulse", r.impulse);
      s.field("angular_impulse", r.angular_impulse);
      s.field("work", r.work);
      s.field("contacts", r.contacts);
    };
    for (Body& b : walls_.bodies) {
      auto g = s.group("body");
      s.field("given", b.given);
      s.field("pose", b.X);
      s.field("twist", b.V);
      s.field("applied_force", b.set.force);
      s.field("applied_torque", b.set.torque);
      report(b.report);
    }
    for (Surface& f : walls_.surfaces) {
      auto g = s.group("surface");
      report(f.report);
    }
  }

 private:
  /// k_max dt^2 <= kStable^2 with k_max the largest sum of k_n/m on a grain.
  static constexpr double kStable = 1.0;

  template <class A>
  static void raw(State& s, const char* name, A& a) {
    using T = typename A::value_type;
    std::vector<std::uint8_t> b;
    if (!s.loading()) {
      b.resize(a.size() * sizeof(T));
      if (!b.empty()) std::memcpy(b.data(), static_cast<const void*>(a.data()), b.size());
    }
    s.field(name, b);
    if (s.loading()) {
      if (b.size() % sizeof(T) != 0) refuse("damaged state: %s", name);
      a.resize(b.size() / sizeof(T));
      if (!b.empty()) std::memcpy(static_cast<void*>(a.data()), b.data(), b.size());
    }
  }

  void look_at_materials() {
    several_ = std::any_of(material_.begin(), material_.end(), [](std::uint8_t m) { return m != 0; });
  }

  void put(const GrainState& in, Grain<R>& g) const {
    space_.put(in.x, g);
    g.r = static_cast<R>(in.radius);
    const double m = 4.0 / 3 * kPi * in.radius * in.radius * in.radius * in.density;
    g.im = in.frozen ? R(0) : static_cast<R>(1 / m);
    g.ii = in.frozen ? R(0) : static_cast<R>(1 / (0.4 * m * in.radius * in.radius));
    for (int k = 0; k < 3; ++k) {
      g.v[k] = static_cast<R>(in.frozen ? 0 : in.v[k]);
      g.w[k] = static_cast<R>(in.frozen ? 0 : in.w[k]);
    }
    g.touching = 6;
  }

  /// Where the arrays are changes with every sort.
  StepWork<R> work() {
    StepWork<R> w{};
    w.grains = grains_.data();
    w.loads = loads_.data();
    w.law = &table_;
    for (int k = 0; k < 3; ++k) {
      w.unit[k] = static_cast<R>(space_.unit(k));
      w.gravity[k] = static_cast<R>(set.gravity[k]);
    }
    w.dt = static_cast<R>(set.dt);
    w.implicit = set.law.damping == Damping::implicit_ ? w.dt : R(0);
    w.drag = static_cast<R>(set.drag);
    w.many = several_;
    w.rate = set.law.rolling != RollingCoefficient::constant;
    w.rate_without_spin = set.law.rolling == RollingCoefficient::rate_without_spin;
    w.spring_cap = set.law.cap == Cap::springs;
    w.ch3 = set.law.model == ContactModel::hertz_ch3;
    for (const PairProperties& p : set.materials.pairs) w.cohesive = w.cohesive || p.cohesion > 0;
    return w;
  }

  const std::vector<Chunk>& chunks() const { return lists_.chunks(); }

  /// By all threads of the team; false when it failed.
  bool sort(Team& team, int t) {
    const auto begin = std::chrono::steady_clock::now();
    if (!lists_.rebuild(team, t, space_, grains_, ids_)) return false;
    return team.wait([&] {
      walls_.renumber(lists_.new_index(), chunks().size());
      loads_.assign(grains_.size(), Load<R>{});
      limits_.assign(chunks().size(), StepLimits{});
      energies_.assign(chunks().size(), Energies{});
      seconds_.assign(chunks().size(), 0.0);
      sort_due_ = false;
      ++counters_.rebuilds;
      counters_.seconds_lists += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    });
  }

  void refresh(std::size_t c) {
    const auto begin = std::chrono::steady_clock::now();
    Chunk& here = lists_.chunks()[c];
    if (here.pairs_due)
      lists_.refresh(c, space_, set.dt, grains_, ids_, pair_type_, material_,
                     static_cast<int>(set.materials.materials.size()));
    if (here.walls_due)
      walls_.refresh(c, space_, set.dt, grains_, here, lists_.spare(c), ids_, material_, set.materials);
    seconds_[c] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  void contacts(std::size_t c, const StepWork<R>& w, const KernelOf<R>& k) {
    if (chunks()[c].pairs_due || chunks()[c].walls_due) refresh(c);
    Energies* e = set.ledger ? &(energies_[c] = Energies{}) : nullptr;
    if (!walls_.empty()) {
      walls_.geometry(c, space_, grains_, ids_.size(), k);
      walls_.each_surface(c, [&](const Motion<R>& motion, WallBlock<R>* first, WallBlock<R>* last, WallSum& sum) {
        k.walls(w, motion, first, last, sum, e);
      });
    }
    k.pairs(w, lists_.first(c), lists_.last(c), lists_.past(c), e);
  }
  void move(std::size_t c, const StepWork<R>& w, const KernelOf<R>& k) {
    Chunk& here = lists_.chunks()[c];
    k.integrate(w, here.first, here.last, limits_[c]);
    here.speed = std::sqrt(limits_[c].speed2);
    here.travelled += here.speed * set.dt;
  }
  /// Contacts and motion of the chunks of thread t, an even number in a row. A chunk is moved as soon as its sums are
  /// complete, while it is still in cache. An odd chunk waits for both its neighbours, the last one for the first chunk
  /// of the next thread.
  void sweep(Team& team, int t, long step, const StepWork<R>& w, const KernelOf<R>& k) {
    const std::size_t n = chunks().size();
    if (n == 1) {
      contacts(0, w, k);
      move(0, w, k);
      return;
    }
    const auto [from, to] = team.share(n / 2, t);
    contacts(2 * from, w, k);
    team.first_done(t, step);
    for (std::size_t c = 2 * from; c < 2 * to; c += 2) {
      if (c + 2 < 2 * to)
        contacts(c + 2, w, k);
      else
        team.wait_for_first((t + 1) % team.size(), step);
      contacts(c + 1, w, k);
      move(c + 1, w, k);
      move((c + 2) % n, w, k);
    }
  }

  void finish_step() {
    double speed = 0, stiffness = 0;
    for (std::size_t c = 0; c < limits_.size(); ++c) {
      if (!(limits_[c].speed2 < 1e6)) speed = 1e9;
      stiffness = std::max(stiffness, limits_[c].stiffness);
      if (seconds_[c] > 0) ++renewed_;
      counters_.seconds_lists += seconds_[c];
      seconds_[c] = 0;
    }
    stiffest_ = std::max(stiffest_ * 0.999, stiffness);
    if (stiffness * set.dt * set.dt > kStable * kStable)
      refuse("at t = %.6g s the step %.3g s is too large for the stiffness of the contacts; at most %.3g s", time,
             set.dt, kStable / std::sqrt(stiffness));
    if (speed > 0)
      refuse(
          "velocities are no longer finite at t = %.6g s: the step %.3g s is too large, or a grain was shot out of the "
          "domain",
          time, set.dt);
    walls_.finish(set.dt, set.gravity, counters_.steps > 0);
    if (set.ledger) count_energies();
    walls_.forget_past();
    sort_due_ = lists_.find_due(space_, grains_, walls_.travelled);
    time += set.dt;
    ++counters_.steps;
    if (set.adapt > 0) follow_stiffness(stiffness);
  }

  /// Down as far as it must, up by a quarter at most.
  void follow_stiffness(double stiffness) {
    const bool near = stiffness * set.dt * set.dt > 0.8 * 0.8 * kStable * kStable;
    if (!near && counters_.steps % static_cast<std::uint64_t>(kAdaptEvery) != 0) return;
    const double aim = std::min(set.dt_largest, set.adapt * stable_step());
    if (aim < set.dt)
      set.dt = aim;
    else if (aim > 1.1 * set.dt)
      set.dt = std::min(aim, 1.25 * set.dt);
  }

  void count_energies() {
    Ledger& l = ledger_;
    l.normal_spring = l.tangential_spring = l.rolling_spring = 0;
    Energies sum;
    for (const Energies& e : energies_) {
      l.normal_spring += e.normal_spring;
      l.tangential_spring += e.tangential_spring;
      l.rolling_spring += e.rolling_spring;
      sum.normal_damping += e.normal_damping;
      sum.tangential_damping += e.tangential_damping;
      sum.rolling_damping += e.rolling_damping;
      sum.sliding += e.sliding;
      sum.rolling_slip += e.rolling_slip;
      sum.tangential_change += e.tangential_change;
      sum.rolling_change += e.rolling_change;
      sum.cohesion += e.cohesion;
    }
    // Positions are known at whole steps: so are the energies, motion by the mean of the half steps around.
    const double kinetic = kinetic_energy(), kept = 1 - set.drag * set.dt;
    const double drag = kinetic * (1 / (kept * kept) - 1);
    l.kinetic = 0.5 * (kinetic_before_ + kinetic);
    if (counters_.steps == 0) {
      l.start = l.held();
    } else {
      l.normal_damping += sum.normal_damping;
      l.tangential_damping += sum.tangential_damping;
      l.rolling_damping += sum.rolling_damping;
      l.sliding += sum.sliding;
      l.rolling_slip += sum.rolling_slip;
      l.tangential_change += sum.tangential_change;
      l.rolling_change += sum.rolling_change;
      l.cohesion += sum.cohesion;
      l.gravity += set.dt * set.gravity.dot(momentum_before_);
      l.drag += 0.5 * (drag_before_ + drag);
    }
    kinetic_before_ = kinetic;
    drag_before_ = drag;
    momentum_before_ = momentum();
  }

  Space<R> space_;
  struct Size {
    double radius, density;
  };
  std::vector<Size> size_;
  LawTable<R> table_;
  std::vector<std::uint8_t> pair_type_, material_;
  Array<Grain<R>> grains_;
  Array<Load<R>> loads_;
  std::vector<std::uint32_t> ids_;
  Lists<R> lists_;
  Bodies<R> walls_;
  std::vector<StepLimits> limits_;
  std::vector<Energies> energies_;
  Ledger ledger_;
  double kinetic_before_ = 0, drag_before_ = 0;
  Vec3 momentum_before_ = Vec3::Zero();
  Counters counters_;
  std::vector<double> seconds_;  ///< spent on the lists of a chunk in this step
  std::uint64_t renewed_ = 0;    ///< lists of chunks
  bool sort_due_ = false;
  double stiffest_ = 0;
  double largest_ = 0;    ///< radius at the start
  bool several_ = false;  ///< grains of other materials than the first
};

void check_grain(const SolverSettings& s, std::size_t k, const GrainState& g) {
  if (!g.x.allFinite() || !g.v.allFinite() || !g.w.allFinite())
    refuse_grains({k}, "grain %zu: position, velocity or spin is not a number", k);
  if (!(g.radius > 0) || !std::isfinite(g.radius))
    refuse_grains({k}, "grain %zu: radius %g m must be positive", k, g.radius);
  if (!(g.density > 0) || !std::isfinite(g.density))
    refuse_grains({k}, "grain %zu: density %g kg/m3 must be positive", k, g.density);
  if (g.material < 0 || g.material >= static_cast<int>(s.materials.materials.size()))
    refuse_grains({k}, "grain %zu: material %d; there are %zu", k, g.material, s.materials.materials.size());
  for (int a = 0; a < 3; ++a)
    if (!s.domain.periodic[static_cast<std::size_t>(a)] && !(g.x[a] >= s.domain.lo[a] && g.x[a] < s.domain.hi[a]))
      refuse_grains({k}, "grain %zu: %c = %g m is outside the domain, %g to %g m", k, "xyz"[a], g.x[a], s.domain.lo[a],
                    s.domain.hi[a]);
}

void check(const SolverSettings& s, const std::vector<GrainState>& grains) {
  if (grains.empty()) refuse("no grain");
  if (!(s.dt > 0) || !std::isfinite(s.dt)) refuse("time step %g s must be positive", s.dt);
  if (!(s.skin >= 2e-4)) refuse("skin %g m is too small; at least 0.2 mm", s.skin);
  if (s.adapt != 0 && !(s.adapt > 0 && s.adapt <= 0.8))
    refuse("an adaptive step follows %g of the stable one; above 0 and at most 0.8 is allowed", s.adapt);
  if (s.adapt > 0 && !(s.dt_largest >= s.dt))
    refuse("the largest step %g s is less than the first, %g s", s.dt_largest, s.dt);
  for (std::size_t k = 0; k < grains.size(); ++k) check_grain(s, k, grains[k]);
}

}  // namespace

double rayleigh_time(const Material& m, double radius, double density) {
  const double shear = m.young / (2 * (1 + m.poisson));
  return kPi * radius * std::sqrt(density / shear) / (0.1631 * m.poisson + 0.8766);
}

static std::unique_ptr<Solver::Impl> engine(const SolverSettings& s, const std::vector<GrainState>& grains,
                                            std::vector<GrainState>* spent) {
  check(s, grains);
  if (s.precision == Precision::full) return std::make_unique<Engine<double>>(s, grains, spent);
  return std::make_unique<Engine<float>>(s, grains, spent);
}
Solver::Solver(const SolverSettings& s, const std::vector<GrainState>& grains) : impl_(engine(s, grains, nullptr)) {}
Solver::Solver(const SolverSettings& s, std::vector<GrainState>&& grains) : impl_(engine(s, grains, &grains)) {}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

int Solver::add_body(const BodySettings& b) { return impl_->add_body(b); }
int Solver::add_plane(int body, const Vec3& point, const Vec3& normal, int material) {
  if (!(normal.norm() > 0)) refuse("normal of a plane is zero");
  return impl_->add_surface(body, Shape::plane(point, normal), material);
}
int Solver::add_mesh(int body, const Mesh& mesh, int material, bool solid) {
  if (mesh.triangles.empty()) refuse("mesh without triangles");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& k = mesh.triangles[t];
    for (int v : k)
      if (v < 0 || v >= static_cast<int>(mesh.vertices.size()))
        refuse("triangle %zu names vertex %d of %zu", t, v, mesh.vertices.size());
    const auto at = [&](std::size_t c) { return mesh.vertices[static_cast<std::size_t>(k[c])]; };
    if (!((at(1) - at(0)).cross(at(2) - at(0)).norm() > 1e-14)) refuse("triangle %zu has no area", t);
  }
  if (solid && mesh.open_edges() > 0)
    refuse("the mesh is open: %zu edges belong to one triangle only; a solid body needs a closed mesh",
           mesh.open_edges());
  return impl_->add_surface(body, Shape::mesh(mesh, solid), material);
}
int Solver::add_cylinder(int body, double radius, double half_width, int material) {
  if (!(radius > 0) || !(half_width > 0))
    refuse("cylinder of radius %g m, half width %g m: both must be positive", radius, half_width);
  return impl_->add_surface(body, Shape::cylinder(radius, half_width), material);
}
int Solver::add_spheres(int body, const std::vector<Vec3>& centres, const std::vector<double>& radii, int material) {
  if (centres.empty() || centres.size() != radii.size())
    refuse("%zu centres and %zu radii", centres.size(), radii.size());
  return impl_->add_surface(body, Shape::spheres(centres, radii), material);
}
int Solver::add_floor(double z, int material) {
  const int b = add_body({});
  add_plane(b, Vec3(0, 0, z), Vec3::UnitZ(), material);
  return b;
}
void Solver::set_motion(int body, const Twist& V) { impl_->body(body).V = V; }
void Solver::place(int body, const Pose& X) { impl_->place(body, X); }
void Solver::set_load(int body, const Vec3& force, const Vec3& torque) {
  impl_->body(body).set.force = force;
  impl_->body(body).set.torque = torque;
}
Pose Solver::pose(int body) const { return impl_->body(body).X; }
Twist Solver::twist(int body) const { return impl_->body(body).V; }
SurfaceReport Solver::body(int body) const { return impl_->body(body).report; }
std::vector<BodyContact> Solver::contacts(int body) const {
  impl_->body(body);  // refuses another number
  return impl_->contacts(body);
}
SurfaceReport Solver::surface(int surface) const { return impl_->surface(surface).report; }
void Solver::step(long n) { impl_->step(n); }
void Solver::step_for(double seconds) {
  if (impl_->set.adapt == 0) return impl_->step(std::lround(seconds / impl_->set.dt));
  const double end = impl_->time + seconds;
  // Pieces in which the step rarely changes.
  for (long n = 1; n > 0;) {
    n = std::min(std::lround((end - impl_->time) / impl_->set.dt), kAdaptEvery);
    impl_->step(n);
  }
}
void Solver::replace(const std::vector<std::size_t>& numbers, const std::vector<GrainState>& grains) {
  if (!impl_->set.exchange) refuse("grains may be replaced with settings.exchange only");
  if (impl_->set.ledger) refuse("replaced grains are not in the energy ledger");
  if (numbers.size() != grains.size()) refuse("replace: %zu numbers and %zu grains", numbers.size(), grains.size());
  for (std::size_t k = 0; k < grains.size(); ++k) check_grain(impl_->set, numbers[k], grains[k]);
  impl_->replace(numbers, grains);
}
double Solver::time() const { return impl_->time; }
std::vector<GrainState> Solver::grains() const { return impl_->grains(); }
double Solver::kinetic_energy() const { return impl_->kinetic_energy(); }
Ledger Solver::ledger() const { return impl_->ledger(); }
Vec3 Solver::momentum() const { return impl_->momentum(); }
double Solver::stable_step() const { return impl_->stable_step(); }
void Solver::set_dt(double dt) { impl_->set.dt = dt; }
double Solver::time_step() const { return impl_->set.dt; }
void Solver::set_drag(double d) { impl_->set.drag = d; }
Counters Solver::counters() const { return impl_->counters(); }
const char* Solver::isa() const { return impl_->kernel->name; }
std::uint64_t Solver::hash() const {
  State s;
  impl_->traverse(s);
  return s.hash();
}
void Solver::traverse(State& s) { impl_->traverse(s); }

}  // namespace grouser::dem
