#pragma once
// Soil that rolls with a wheel: a periodic bed of constant length and constant number of grains, of any travel.
//
//   slot k = [k b, (k + 1) b), b the length of the brick that was poured once; n slots go round along x.
//   When the wheel enters slot w, slots up to w + ahead are fresh: what was left behind in slot (w + ahead) mod n is taken away
//   and the brick is laid there as it was poured, at rest.
//
// Where fresh soil meets what the wheel left behind, one largest diameter on either side is frozen, so that the two do not push each
// other (so from the start, at x = 0); the fresh side is freed when the next brick follows on it, which it joins as tiles do. Grains belong to the slot they lie
// in: what the wheel pushes along stays with it. Grains that a slot has too many or too few come from and go to a store of frozen
// grains at the top of the domain, so the solver's number of grains never changes.
// The wheel starts in slot 1 or later. Limits: travel along +x; the bed has to be at rest where it is cut; the energy ledger cannot follow.
#include <vector>

#include "grouser/dem/packing.h"
#include "grouser/terrain/state.h"

namespace grouser::dem {

struct RollingBedSettings {
  int bricks = 6;      ///< along x
  int ahead = 2;       ///< fresh bricks kept in front of the one under the wheel, 1 to bricks - 3
  double spare = 0.5;  ///< grains in store at the start, as a share of a brick's, above 0
  double room = 0.1;   ///< free height above the surface, below the store [m]
};

class RollingBed {
 public:
  /// @throws DemError: settings out of range, a brick that is not periodic, has frozen grains or is shorter than four of its largest
  /// grains.
  RollingBed(const Packing& brick, const RollingBedSettings& s);
  /// What the solver is made with: domain and exchange are set, the rest is the caller's. Floor and bodies are added afterwards.
  SolverSettings fit(SolverSettings s) const;
  std::vector<GrainState> grains() const;  ///< n bricks and the store
  /// Between steps, with the wheel at x [m], which may be any distance: lays what is due; returns the number of bricks laid.
  /// Cost: about that of a hundred steps per brick. @throws DemError: the store is empty; the wheel went back over soil that is gone.
  int follow(Solver& solver, double x);

  double length() const { return bricks_ * brick_.lx; }  ///< of the bed [m]
  double fresh_until() const;                            ///< [m], as far as x counts
  std::size_t stored() const { return store_.size(); }   ///< grains that are no soil now
  bool in_store(std::size_t number) const;
  long laid() const { return next_ - bricks_; }               ///< bricks since the start
  const Vec3& removed_momentum() const { return momentum_; }  ///< of grains taken away or frozen [kg m/s]
  void traverse(State& s);                                    ///< beside the solver's own

 private:
  void lay(Solver& solver);
  GrainState in_storage(std::size_t place, GrainState g) const;

  Packing brick_;
  int bricks_, ahead_;
  double border_ = 0, store_from_ = 0, top_ = 0;
  std::size_t spare_ = 0;
  std::vector<std::int64_t> store_;  ///< numbers of grains, a stack
  long next_ = 0;                    ///< slot to be laid next, as far as x counts
  Vec3 momentum_ = Vec3::Zero();
};

}  // namespace grouser::dem
