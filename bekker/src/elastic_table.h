#pragma once
#include <vector>

#include "steady_force.h"

namespace grouser::bekker {

/// Energy E(h) = integral of Fz(h) dh of a wheel pressed in without slip [J]: the recoverable vertical part of the model. Cubic Hermite
/// over sqrt(h/(2 r)).
class ElasticTable {
 public:
  ElasticTable() = default;
  ElasticTable(const WheelSize& wheel, const SoilLaw& soil, Method method, int points);
  struct Value {
    double energy, force;  ///< [J], [N] = dE/dh of the interpolant
  };
  Value at(double sinkage) const;

 private:
  double radius_ = 0;
  std::vector<double> energy_, slope_;  ///< E and dE/ds at the nodes
};

}  // namespace grouser::bekker
