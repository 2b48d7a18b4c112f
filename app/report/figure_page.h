#pragma once
// One offline HTML page of figures and tables with text between them: `grouser plot`, `grouser fit`.
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace grouser::report {

struct Series {
  enum class Style { line, dashed, points };
  std::string name;
  Style style = Style::line;
  std::vector<double> x, y;   ///< same length; NaN = gap
  std::vector<double> error;  ///< empty, or half height of the error bar at each point
  int colour = -1;            ///< index into the page's palette; -1 = next
};

struct Plot {
  std::string title, x_label, y_label;  ///< labels with unit: "sinkage [mm]"
  std::string caption;                  ///< what to see, below the plot
  std::vector<Series> series;
  bool log_x = false, log_y = false;
};

struct FigureTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< as shown
};

struct Paragraph {
  std::string text;  ///< plain text; an empty line starts a new paragraph
};

struct FigurePage {
  std::string title, summary;  ///< summary: the first sentence of the page
  std::vector<std::variant<Plot, FigureTable, Paragraph>> items;
};

/// @throws ResultsError: the file cannot be written, or a series has unequal lengths (names it).
void write_figure_page(const FigurePage& page, const std::filesystem::path& html);

}  // namespace grouser::report
