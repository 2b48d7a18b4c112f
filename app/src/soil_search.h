#pragma once
// Search in the unit cube for a function that is dear and rough: a space-filling set first, then a search without
// derivatives from its best point. Knows nothing of grains.
#include <functional>
#include <string>
#include <vector>

namespace grouser::app {

using Point = std::vector<double>;

struct SearchSettings {
  std::size_t first = 8;          ///< points of the space-filling set (Sobol, shifted by the seed), at least 1
  std::size_t most = 24;          ///< points in all
  unsigned seed = 1;              ///< of the shift
  std::string method = "bobyqa";  ///< one of search_methods()
  double step = 0.2;              ///< first step of the method, in (0, 0.5]
  double tolerance = 0.01;        ///< step at which it ends
};

/// bobyqa (Powell 2009: quadratic model), sbplx (Rowan 1990) and nelder-mead: those of NLopt.
const std::vector<std::string>& search_methods();

/// Values at the points of one batch, in their order; what it throws ends the search and is passed on.
using Values = std::function<std::vector<double>(const std::vector<Point>&)>;

/// Asks for the space-filling set in one batch, then for one point at a time. The same settings and values lead to the same
/// points, bit for bit. Points may be asked for twice.
/// @throws std::invalid_argument: unknown method, no dimension, first or most of zero.
void search(std::size_t dimensions, const SearchSettings& s, const Values& values);

/// Which points no other one beats: less or equal in both values and less in one. Points with a value that is not finite are
/// beaten.
std::vector<bool> pareto_front(const std::vector<double>& a, const std::vector<double>& b);

struct Slope {
  double value = 0, half_width = 0;  ///< half width of the 95 % interval (Student); NaN: too few points
};
/// Slopes b_i of the plane y = a + sum b_i x_i through the points (least squares), one per coordinate.
/// Empty: fewer points than unknowns, or points in one plane.
std::vector<Slope> plane_through(const std::vector<Point>& x, const std::vector<double>& y);

}  // namespace grouser::app
