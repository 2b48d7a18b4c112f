#pragma once
#include "grouser/dem/packing.h"
#include "grouser/terrain/state.h"

namespace grouser::dem {

/// Loose grains in a column above z = 0, none overlapping, of this solid volume together; inside, not wrapped, between walls.
std::vector<GrainState> scatter(const SoilSettings& soil, const PourSettings& p, double solid_volume);
/// Floor and the walls that there are.
void add_container(Solver& solver, const PourSettings& p);
void set_domain(SolverSettings& s, const PourSettings& p, double top);
/// Mean over squares of the highest grain top [m].
double surface_height(const std::vector<GrainState>& grains, double lx, double ly, double square);
double total_mass(const std::vector<GrainState>& grains);
/// Mass-weighted rms velocity of the grains that are not frozen [m/s].
double rms_speed(const std::vector<GrainState>& grains);
/// What every solver of this soil has.
SolverSettings solver_settings(const SoilSettings& soil);

/// Coming to rest, 20 ms at a time, until the rms velocity is below `slow` [m/s] twice in a row (so that the turn of a
/// bounce is not taken for rest), or `limit` [s] have passed.
class Settling {
 public:
  Settling(double slow, double limit) : slow_(slow), limit_(limit) {}
  /// False: at rest.
  bool step(Solver& solver);
  double spent() const { return spent_; }
  double left() const { return limit_ - spent_; }
  double speed() const { return last_; }
  void traverse(State& s);

 private:
  double slow_, limit_, spent_ = 0, last_ = 1e30;
};

/// "name value" with all digits.
void put_line(std::string& text, const char* name, double value);
void put_line(std::string& text, const char* name, const std::string& value);

}  // namespace grouser::dem
