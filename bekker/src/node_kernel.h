#pragma once
// Stress, memory and energy of the soil nodes under one gear, several nodes at a time. One function per instruction
// set, picked at run time.
// Frame: axes of the grid, origin at the hub. Plain arrays only: this header is compiled for several instruction sets.
namespace grouser::bekker::node {

constexpr int kSide = 16;             ///< nodes along a side of a tile
constexpr int kTile = kSide * kSide;  ///< nodes of a tile, index i * kSide + j: i along the grid's x, j along its y
constexpr int kBlock = 8;             ///< nodes that are worked on together, whatever the instruction set

/// State of a node. Pressed: `cover` > 0.
enum Field {
  kZu,     ///< plastic depth [m]: where the pressure last followed the virgin curve, deepest so far under any one gear
  kKu,     ///< unloading slope [Pa/m], > 0
  kZs,     ///< depth of the unloaded surface [m]: the pressure is ku (z - zs) up to zu
  kZ,      ///< depth of the gear's surface at the last step [m]
  kCover,  ///< share of the node's cell under the gear; 0 = not pressed
  kJ,      ///< shear displacement made by loading [m]
  kY,      ///< largest elastic shear displacement that the soil bears now, K0 f(J) [m]
  kU1,     ///< elastic shear displacement in the surface's own axes [m]
  kU2,
  kG,    ///< shear stiffness times area [N/m]
  kRut,  ///< depth at which the gear met the node [m]
  kFields
};

/// Place of a field of node `at` in a tile's array: the fields of a block lie beside one another, so that a block is one
/// run of memory.
constexpr int place(Field f, int at) { return ((at / kBlock) * kFields + f) * kBlock + at % kBlock; }

/// One soil for one gear and step.
struct Material {
  double modulus, n;         ///< p = modulus z^n [Pa/m^n], [-]
  double ko, Au, ratio;      ///< unloading slope max(ko + Au zu, ratio pu/zu)
  double cohesion, tan_phi;  ///< [Pa], [-]
  double K, K0, residual;    ///< displacement in f, initial K0 = 1/f'(0) [m]; Kr of type C
  int shear_type;            ///< 0 A, 1 B, 2 C
  // Named effects; as they stand here they change nothing.
  double per_pan = 0;           ///< 1/H of a hard pan [1/m]
  double more = 0, per_Kw = 0;  ///< shear curve times 1 + more exp(-J per_Kw); K0 holds it already [-, 1/m]
  double again = 1,
         stronger = 1;  ///< modulus and tan phi of a node that was pressed in an earlier pass, times these [-]
};

struct Gear {
  double X[3], Y[3], Z[3];    ///< carrier axes
  double V[3], W[3];          ///< twist of the hub
  double radius, half_width;  ///< [m]; over the lugs
  double tip_share;           ///< mu of eq 2.15, lugs carried as a mean; 1 without
  double tread, hollow;       ///< [m] the tread between them: its radius, and its curvature across the width (0: none)
  double reach;               ///< |x_C| below which the surface may touch [m]
  double spacing, area;       ///< [m], [m^2] of a node
  double dt;
  double soil_damping;                ///< chi [s/m]
  double pressure_rate, shear_rate;   ///< m, zeta [-]
  double rate_reference, rate_least;  ///< v0, v_min [m/s]
};

/// Part of a tile: rows i0..i1 - 1, nodes j0..j1 - 1 (multiples of kBlock).
struct Segment {
  double* nodes;              ///< kFields * kTile doubles, see place(); on a boundary of 64 bytes for speed
  const double* height;       ///< undisturbed ground above the hub [m] when `base` is added
  const double* surface;      ///< null for a smooth cylinder; else 5 arrays: height, normal (3), cover
  const unsigned char* soil;  ///< material of each node, null when there is one
  double x0, y0;              ///< node (0, 0) from the hub [m]
  double base;                ///< [m] minus height of the hub
  int i0, i1, j0, j1;
};

struct Sums {
  double force[3], moment[3];
  double K[36];                                    ///< dF/dx, row-major
  double damping[36];                              ///< dF/dv
  double stored, dissipated, integration, placed;  ///< [J]
  double rut, cover;                               ///< sum of cover * depth at meeting, sum of cover of pressed nodes
  double front, rear;                              ///< largest and least x_C of pressed nodes; -1e30 and 1e30 when none
};

using Kernel = void (*)(const Gear&, const Material*, int materials, const Segment*, int segments, Sums&);
Kernel kernel();

}  // namespace grouser::bekker::node
