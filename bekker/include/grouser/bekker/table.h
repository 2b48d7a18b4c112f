#pragma once
// Lookup table of one wheel on one soil: entry angle, thrust, resistance, torque, sinkage and the unloading sinkage it
// leaves, over slip x load x unloading sinkage of an earlier pass. Built once (seconds), asked in a fraction of a
// microsecond.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "grouser/bekker/forces.h"

namespace grouser::bekker {

struct TableRange {
  double lower = 0, upper = 0;
  bool contains(double x) const { return x >= lower && x <= upper; }
};

/// What a table is built of.
struct TableSpec {
  std::string title;
  WheelSize wheel;
  SoilLaw soil;
  TableRange slip;               ///< [-] inside -1..1
  TableRange load;               ///< [N] > 0
  TableRange unloading_sinkage;  ///< [m] >= 0, left by an earlier pass; upper = 0: virgin soil only
  /// Largest error anywhere in the ranges: thrust, resistance and drawbar pull as a share of the load, torque as a
  /// share of load times outer radius, entry angle and sinkage as a share of themselves. 1e-5..0.1.
  double error_bound = 1e-3;
  Method method = Method::nonlinear;
  std::size_t largest_grid = 4'000'000;  ///< points; a bound that needs more is refused
  std::string inputs;                    ///< YAML text of the table's, wheel's and soil's files, stored with the table
};

/// Reads TABLE.yaml (schema in bekker/README.md) with the wheel and soil files that it names. @throws ConfigError with
/// every error.
TableSpec load_table_spec(const std::filesystem::path& file);

/// A table that cannot be built: a corner of the ranges has no equilibrium, or the error bound needs too many points.
struct TableError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class TableStatus { ok, slip_out_of_range, load_out_of_range, unloading_sinkage_out_of_range };
std::string_view name_of(TableStatus status);

struct TablePoint {
  double entry_angle = 0;        ///< theta_f [rad] to the undisturbed ground
  double thrust = 0;             ///< [N] shear stress's share of the drawbar pull
  double resistance = 0;         ///< [N] pressure's share, positive against the travel
  double torque = 0;             ///< [N m] driving
  double sinkage = 0;            ///< [m] of the lowest point
  double unloading_sinkage = 0;  ///< [m] that this pass leaves: the larger of the earlier one and `sinkage`
  double drawbar() const { return thrust - resistance; }
};

/// Cubic B-splines on uniform grids, in blocks that are smooth inside: driving and braking; staying in the rut of the
/// earlier pass and going deeper, with the load between the two as the edge of the blocks. Axes: slip (braking: root of
/// -slip over the entry angle), log of the load from the edge, unloading sinkage.
/// Range: theta_m, theta_r, pressure and shear as in SoilLaw; slip angle 0. Lugs: see bekker/README.md.
/// Source: dissertation section 2.3 and Fig 2.7 for what is tabulated; the blocks are this project's own.
class WheelTable {
 public:
  struct Progress {
    const char* part = "";            ///< what is being computed
    std::size_t done = 0, total = 0;  ///< points of this pass; a further pass with a finer grid may follow
  };
  /// Same bits for any number of threads. @throws TableError; std::invalid_argument for a spec outside its ranges.
  static WheelTable build(const TableSpec& spec, int threads = 1,
                          const std::function<void(const Progress&)>& progress = {});

  /// HDF5 file with units, descriptions, the inputs and a hash. @throws ResultsError.
  void write(const std::filesystem::path& file, const std::string& version) const;
  /// @throws ResultsError: missing, truncated, not a table, another format version, content and hash differ.
  static WheelTable read(const std::filesystem::path& file);

  /// Interpolated values. Outside the ranges (or for NaN) `out` is left as it is and the status names the first input
  /// outside: a table never extrapolates. No allocation. Cost: bekker/README.md.
  TableStatus query(double slip, double load, double unloading_sinkage, TablePoint& out) const noexcept;

  const TableSpec& spec() const;
  double error_found() const;     ///< largest error at the points between the grid's that the build checked
  std::size_t points() const;     ///< of all grids
  std::string grid_text() const;  ///< "driving, deeper than the rut: 24 x 12 x 10; ..."
  std::uint64_t hash() const;     ///< of inputs, ranges and values
  std::string hash_text() const;  ///< 16 hexadecimal digits
  std::string version() const;    ///< of the program that wrote the file; "" for a table just built

  WheelTable(WheelTable&&) noexcept;
  WheelTable& operator=(WheelTable&&) noexcept;
  ~WheelTable();

  struct Data;  ///< internal

 private:
  explicit WheelTable(std::unique_ptr<Data> d);
  std::unique_ptr<Data> data_;
  friend class TableBuilder;
};

}  // namespace grouser::bekker
