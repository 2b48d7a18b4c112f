#pragma once
// Spheres in contact, stepped in time.
//
//   m dv/dt = sum F + m g,   I dw/dt = sum T        leap-frog: v at half steps, x at whole steps
//
// with the contact law of the module's README (equations D1 to D14). SI units, z up.
// Cost: about 20 ns per grain and step on one AVX-512 core (README, "Speed"), 250 bytes per grain, 380 while it sorts.
#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "grouser/dem/material.h"
#include "grouser/dem/surface.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/types.h"

namespace grouser::dem {

/// Wrong input or a run that cannot go on; the message says what, where and what would be allowed.
struct DemError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The same where grains are to blame; `grains`: their numbers as given.
struct GrainError : DemError {
  GrainError(const std::string& text, std::vector<std::size_t> numbers) : DemError(text), grains(std::move(numbers)) {}
  std::vector<std::size_t> grains;
};

struct GrainState {
  Vec3 x = Vec3::Zero();                    ///< [m]
  double radius = 0.0025;                   ///< [m]
  double density = 3100;                    ///< [kg/m3]
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();  ///< [m/s], [rad/s]
  int material = 0;
  bool frozen = false;
};

/// Time in which a wave on the surface of a sphere of radius r goes half round it, a measure for steps [s]:
/// T_R = pi r sqrt(rho/G)/(0.1631 nu + 0.8766), G = Y/(2 (1 + nu)).
double rayleigh_time(const Material& m, double radius, double density);

/// Box of the grains. Periodic axes wrap; on the others a grain that leaves stops the run.
struct Domain {
  Vec3 lo = Vec3::Zero(), hi = Vec3::Ones();
  std::array<bool, 3> periodic{true, true, false};
};

enum class Precision {
  single,  ///< float in the loop, positions as 32-bit fixed point with the rounding carried on: 0.3 nm per metre of box
  full     ///< the same loop in double with 64-bit positions: the reference
};

struct SolverSettings {
  Domain domain;
  MaterialTable materials;
  LawSettings law;
  double dt = 8e-6;  ///< [s]
  Vec3 gravity{0, 0, -9.81};
  double drag = 0;     ///< [1/s] decay of velocity and spin, for preparation
  double skin = 1e-3;  ///< [m] reach of the list of neighbours beyond contact
  Precision precision = Precision::single;
  int threads = 1;
  bool ledger = false;  ///< keep the energy ledger: about twice the time
  /// Share of stable_step() that the step follows, in (0, 0.8]; 0: dt is fixed. Looked at every 64 steps, and at once where the
  /// step has come near its limit; it grows by a quarter at most at a time, up to dt_largest. dt is where it begins.
  double adapt = 0;
  double dt_largest = 0;  ///< [s], with adapt
  bool exchange = false;  ///< allow replace(); sizes become part of the state
  std::string isa;        ///< "avx512", "avx2", "base"; empty: the best this machine has
};

/// Energies [J] at the positions of the last forces: springs and motion as they are then, the rest since the first step
/// (README, "Energy"). residual() = held + lost - given is the error of the step, second order.
struct Ledger {
  double kinetic = 0, normal_spring = 0, tangential_spring = 0, rolling_spring = 0;
  double normal_damping = 0, tangential_damping = 0, rolling_damping = 0, sliding = 0, rolling_slip = 0;
  double tangential_change = 0, rolling_change = 0;  ///< lost as springs change stiffness or direction under load
  double drag = 0;
  double cohesion = 0;             ///< held by cohesion, negative
  double gravity = 0, bodies = 0;  ///< work on the grains
  double start = 0;                ///< held at the start
  double held() const { return kinetic + normal_spring + tangential_spring + rolling_spring + cohesion; }
  double lost() const {
    return normal_damping + tangential_damping + rolling_damping + sliding + rolling_slip + tangential_change +
           rolling_change + drag;
  }
  double residual() const { return held() + lost() - gravity - bodies - start; }
};

struct Counters {
  std::uint64_t steps = 0, rebuilds = 0, refreshes = 0;
  std::size_t grains = 0, listed = 0, candidates = 0;  ///< listed: in the contact loop; candidates: within the skin
  double touching = 0;                                 ///< contacts per grain
  double seconds_lists = 0;                            ///< time spent on lists
  std::size_t bytes = 0;
};

class Solver {
 public:
  struct Impl;
  /// @throws DemError: no grain, dt not positive, too few cells along a periodic axis, unknown instruction set.
  /// GrainError: radius or density not positive, NaN, a grain outside the domain, overlap of more than a quarter of the
  /// smaller radius.
  Solver(const SolverSettings& settings, const std::vector<GrainState>& grains);
  /// Frees the list (125 bytes a grain) before it makes its own, so that the peak is that of the solver.
  Solver(const SolverSettings& settings, std::vector<GrainState>&& grains);
  ~Solver();
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;

  /// A body without surfaces; add those next. Returns its number.
  int add_body(const BodySettings& b);
  /// Surfaces of a body, in its frame; each returns its number. @throws DemError: a plane that leans along a periodic
  /// axis or turns, an empty mesh, a triangle without area, an open mesh said to be solid. GrainError: a grain (not
  /// frozen) that is deeper in the surface than a quarter of its radius or, where there is an inside, lies in it.
  int add_plane(int body, const Vec3& point, const Vec3& normal,
                int material = 0);  ///< grains stay where normal points
  /// `solid`: the mesh is closed and full (a wheel, a plate); otherwise it is a sheet (the walls of a box).
  int add_mesh(int body, const Mesh& mesh, int material = 0, bool solid = false);
  int add_cylinder(int body, double radius, double half_width, int material = 0);  ///< about y
  int add_spheres(int body, const std::vector<Vec3>& centres, const std::vector<double>& radii, int material = 0);
  /// Fixed floor z = 0 with grains above; short for a body with a plane. Returns the body.
  int add_floor(double z = 0, int material = 0);

  void set_motion(int body, const Twist& V_W);  ///< of a prescribed body, or of locked directions
  /// Puts a body elsewhere at once, between steps. What it overlaps there is not looked at before the next step.
  void place(int body, const Pose& X_WB);
  void set_load(int body, const Vec3& force, const Vec3& torque = Vec3::Zero());  ///< on a free body
  Pose pose(int body) const;
  Twist twist(int body) const;
  SurfaceReport body(int body) const;
  SurfaceReport surface(int surface) const;
  std::vector<BodyContact> contacts(int body) const;  ///< of the last step

  /// @throws DemError: unstable step, velocities that are not finite. GrainError: a grain left the domain.
  void step(long n);
  /// As many whole steps as fit the time best; with an adaptive step until less than half a step is left.
  void step_for(double seconds);
  double time() const;
  std::vector<GrainState> grains() const;  ///< in the order they were given; velocities half a step behind
  /// @throws DemError when settings.ledger is off.
  Ledger ledger() const;
  double kinetic_energy() const;  ///< [J]
  Vec3 momentum() const;          ///< [kg m/s]
  /// Largest stable step by the stiffness met since the last list, see README "Time step".
  double stable_step() const;
  void set_dt(double dt);
  double time_step() const;  ///< of the next step [s]
  void set_drag(double per_second);
  /// Gives grains (by number) other places, sizes, velocities, materials, or freezes or frees them; their contacts begin anew. What
  /// else they touch there is not looked at before the next step.
  /// @throws DemError: settings.exchange is off, the ledger is on, a number twice or too large, a radius beyond the largest at the
  /// start, what the constructor refuses in a grain.
  void replace(const std::vector<std::size_t>& numbers, const std::vector<GrainState>& grains);
  Counters counters() const;
  const char* isa() const;
  std::uint64_t hash() const;  ///< of all state
  void traverse(State& s);     ///< save, load: continuing is bit-equal

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace grouser::dem
