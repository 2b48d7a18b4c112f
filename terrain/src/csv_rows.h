#pragma once
// Lines and rows of CSV files, for those who read all of a file and those who read it bit by bit.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "grouser/terrain/csv.h"

namespace grouser {

/// Without blanks around it.
std::string_view trimmed_csv(std::string_view s);
/// Takes the first line, without its end, off `rest`.
std::string_view take_line(std::string_view& rest);
/// @throws ConfigError: the first line's cells are separated by something else than commas.
void refuse_other_separator(const std::filesystem::path& file, const CsvFile::Row& first);
/// @throws ConfigError: a folder, or a file that cannot be read.
[[noreturn]] void refuse_unreadable(const std::filesystem::path& file);
/// Splits a line: the header where there are no columns yet. True: `cells` is a row as long as the header; what else is
/// wrong is added to `errors`.
bool split_record(const CsvFile::Row& line, std::vector<std::string>& columns, std::vector<CsvCell>& cells,
                  FileErrors& errors);
/// Said of a file without a header line.
void add_empty_file(FileErrors& errors);

}  // namespace grouser
