#pragma once
// Files of cases for the bekker commands: CSV rows of wheel, soil and state in SI units, checked cell by cell.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "grouser/bekker/forces.h"
#include "grouser/terrain/csv.h"

namespace grouser::app {

/// Columns of a case file; their names carry the units.
enum class CaseColumn {
  c_Pa,
  phi_rad,
  n,
  K_m,
  kc,
  kphi,
  radius_m,
  width_m,
  slip,
  beta_rad,  // all commands with a soil
  theta_f_rad,
  theta_m_rad,
  theta_r_rad,  // forces
  load_N,
  a0,
  a1,
  b0,
  b1,         // solve
  torque_Nm,  // solve --free-slip
  shear_type,
  Kw_m,
  Kr,
  lug_height_m,
  lug_ratio,
  ko,
  Au,
  zu_m,
  lateral,  // optional
};

/// A CSV file with the columns that a command reads. Other columns belong to the user and are passed through.
class CaseFile {
 public:
  /// `required` must be there; `optional` may; `written` are the columns that the command adds.
  /// @throws ConfigError with all errors of the header.
  CaseFile(const std::filesystem::path& file, std::vector<CaseColumn> required, std::vector<CaseColumn> optional,
           const std::vector<std::string>& written);

  std::size_t size() const { return csv_.rows().size() - 1; }
  int line(std::size_t row) const { return csv_.rows()[row + 1].line; }
  int header_line() const { return csv_.rows()[0].line; }
  std::string_view header() const { return csv_.rows()[0].text; }
  /// The row as it stands in the file.
  std::string_view text(std::size_t row) const { return csv_.rows()[row + 1].text; }
  const std::filesystem::path& file() const { return csv_.file(); }
  /// The cells of one row.
  class Row {
   public:
    Row(const CaseFile& file, std::size_t row, FileErrors& errors);
    bool complete() const { return complete_; }
    /// The cell is there and not empty.
    bool has(CaseColumn c) const;
    /// Value in the column's range; an error is noted, and 0 returned, for anything else.
    double number(CaseColumn c);
    double number_or(CaseColumn c, double fallback);
    /// One of `allowed`, by its index.
    std::size_t choice_or(CaseColumn c, const std::vector<std::string>& allowed, std::size_t fallback);
    void error(CaseColumn c, const std::string& message);

   private:
    const CsvCell* cell(CaseColumn c) const;
    const CaseFile& file_;
    FileErrors& errors_;
    std::vector<CsvCell> cells_;
    int line_;
    bool complete_;
  };

 private:
  CsvFile csv_;
  std::size_t columns_ = 0;
  std::vector<int> place_;  ///< of each CaseColumn in a row; -1 = not in the file
};

std::string name_of(CaseColumn c);

extern const std::vector<CaseColumn> force_columns, solve_columns, optional_columns;

bekker::ForceCase force_case(CaseFile::Row& row);
/// `free_slip`: torque_Nm is read by the caller, slip is not.
bekker::LoadCase load_case(CaseFile::Row& row, bool free_slip);

}  // namespace grouser::app
