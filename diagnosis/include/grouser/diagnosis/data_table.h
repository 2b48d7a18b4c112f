#pragma once
// A CSV file of measurements as a fit file names it: which columns, which unit, which rows.
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"

namespace grouser::diagnosis {

/// Cells stay text. One header line; lines that begin with # are notes; cells may be quoted.
///
/// A fit file picks rows and columns of it:
///   file: data/x.csv            relative to the fit file; GROUSER_DATA/x.csv: in the folder of that environment variable,
///                               ../shared/data/measured where it is not set
///   where: {soil: LHS-1}        rows whose cell equals the text (or one of a list); numbers are compared as numbers
///   skip: {position_glitch: 1}  rows to leave out
class DataTable {
 public:
  /// Reads file, where and skip of `node`. Errors (no file, ragged rows, no such column, no row left) are noted in its document and
  /// leave the table empty.
  static DataTable load(const ConfigNode& node);

  std::size_t size() const { return records_.rows.size(); }
  const std::filesystem::path& file() const { return file_; }
  const std::vector<std::string>& columns() const { return records_.columns; }
  int line(std::size_t row) const { return records_.rows[row].line; }  ///< in the file, from 1

  /// One value per row in SI. `key` of `node` is
  ///   a column whose name ends in its unit:  force_N, sinkage_mm, torque_Nm, slip_angle_deg (or none for unit "1")
  ///   {column: name, unit: mm}            (for key `column` of a channel the unit stands next to it: {column: x, unit: N, error: 2 N})
  ///   a constant quantity: 115 N, {value: .., source: ..}, {assumed: .., why: ..}
  /// Cells that are no finite number, a wrong unit and an unknown column are errors with their place. Empty when there is an error.
  std::vector<double> quantity(const ConfigNode& node, const std::string& key, std::string_view unit) const;
  /// Rows that a map {column: value | [values]} picks, all of its columns together. Unknown columns are errors and pick nothing.
  std::vector<bool> picked(const ConfigNode& map) const;
  /// Texts of one or several columns joined by a space: `test: [plate, repeat]`. Absent: every row "".
  std::vector<std::string> label(const ConfigNode& node, const std::string& key) const;

 private:
  std::filesystem::path file_;
  CsvRecords records_;  ///< the rows that are left

  int column(const ConfigNode& node, const std::string& key, const std::string& name) const;
  void keep(const ConfigNode& node, const std::string& key, bool wanted);
};

/// GROUSER_DATA, or its default.
std::filesystem::path measured_data_folder();

}  // namespace grouser::diagnosis
