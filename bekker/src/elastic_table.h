#pragma once
#include <functional>
#include <vector>

#include "steady_force.h"

namespace grouser::bekker {

/// Energy E(h) = integral of Fz(h) dh of a wheel pressed in without slip [J]: the recoverable vertical part of the model. Cubic Hermite
/// over sqrt(h/(2 r)).
class ElasticTable {
 public:
  ElasticTable() = default;
  ElasticTable(const WheelSize& wheel, const SoilLaw& soil, Method method, int points);
  /// Of any force Fz(h) [N], h in 0..2 radius [m].
  ElasticTable(double radius, const std::function<double(double)>& force);
  struct Value {
    double energy, force;  ///< [J], [N] = dE/dh of the interpolant
  };
  Value at(double sinkage) const;

 private:
  void fill(const std::function<double(double)>& slope);

  double radius_ = 0;
  std::vector<double> energy_, slope_;  ///< E and dE/ds at the nodes
};

}  // namespace grouser::bekker
