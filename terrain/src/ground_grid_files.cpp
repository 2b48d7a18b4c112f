#include "grouser/terrain/ground_grid_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "ground_csv.h"
#include "ground_detail.h"

namespace grouser {

namespace {

using namespace ground_detail;

struct Token {
  std::string_view text;
  int line = 0, column = 0;
};

std::vector<Token> tokens_of(std::string_view text) {
  std::vector<Token> out;
  int line = 1;
  std::size_t line_begin = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '\n') {
      ++line;
      line_begin = ++i;
    } else if (c == ' ' || c == '\t' || c == '\r') {
      ++i;
    } else {
      std::size_t e = i;
      while (e < text.size() && text[e] != ' ' && text[e] != '\t' && text[e] != '\r' && text[e] != '\n') ++e;
      out.push_back({text.substr(i, e - i), line, static_cast<int>(i - line_begin) + 1});
      i = e;
    }
  }
  return out;
}

std::string lower(std::string_view s) {
  std::string t(s);
  std::transform(t.begin(), t.end(), t.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return t;
}

struct EsriHeader {
  std::map<std::string, double> values;
  std::size_t end = 0;  ///< first token of the cells
};

EsriHeader esri_header(const std::vector<Token>& tokens, FileErrors& errors) {
  static const std::vector<std::string> known = {"ncols",     "nrows",     "xllcorner", "yllcorner",
                                                 "xllcenter", "yllcenter", "cellsize",  "nodata_value"};
  EsriHeader h;
  std::size_t i = 0;
  while (i < tokens.size() && std::isalpha(static_cast<unsigned char>(tokens[i].text.front()))) {
    const Token& key = tokens[i];
    const std::string name = lower(key.text);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      const auto near = did_you_mean(name, known);
      errors.add(
          key.line, key.column,
          "unknown header entry '" + std::string(key.text) + "'" + (near ? "; did you mean '" + *near + "'?" : "") +
              " An ESRI ASCII grid has ncols, nrows, xllcorner, yllcorner, cellsize and optionally NODATA_value");
    }
    const auto value = i + 1 < tokens.size() ? parse_number(tokens[i + 1].text) : std::nullopt;
    if (!value) {
      errors.add(key.line, key.column, "header entry '" + std::string(key.text) + "' needs a number");
      i += 1;
      continue;
    }
    if (!h.values.emplace(name, *value).second)
      errors.add(key.line, key.column, "header entry '" + std::string(key.text) + "' appears twice");
    i += 2;
  }
  h.end = i;
  const int line = i > 0 ? tokens[i - 1].line : 1;
  for (const char* name : {"ncols", "nrows", "cellsize"})
    if (!h.values.contains(name) && !errors.any()) errors.add(line, 1, std::string("the header lacks '") + name + "'");
  for (const char* axis : {"x", "y"}) {
    const std::string corner = axis + std::string("llcorner"), centre = axis + std::string("llcenter");
    if (!h.values.contains(corner) && !h.values.contains(centre) && !errors.any())
      errors.add(line, 1, "the header lacks '" + corner + "' (or '" + centre + "')");
  }
  errors.check();
  for (const char* name : {"ncols", "nrows"}) {
    const double n = h.values[name];
    if (n != std::floor(n) || n < 2 || n > 100000)
      errors.add(1, 1, std::string(name) + " must be a whole number within 2..100000, got " + number(n));
  }
  if (!(h.values["cellsize"] > 0))
    errors.add(line, 1, "cellsize must be positive, got " + number(h.values["cellsize"]));
  errors.check();
  return h;
}

}  // namespace

HeightGrid read_height_esri(const std::filesystem::path& file, double height_unit) {
  const std::string text = read_text_file(file);
  FileErrors errors(file);
  const std::vector<Token> tokens = tokens_of(text);
  EsriHeader h = esri_header(tokens, errors);

  HeightGrid g;
  g.nx = static_cast<int>(h.values["ncols"]);
  g.ny = static_cast<int>(h.values["nrows"]);
  g.dx = g.dy = h.values["cellsize"];
  // A corner is half a cell from the centre of its cell, and the centres are the nodes.
  g.x0 = h.values.contains("xllcenter") ? h.values["xllcenter"] : h.values["xllcorner"] + 0.5 * g.dx;
  g.y0 = h.values.contains("yllcenter") ? h.values["yllcenter"] : h.values["yllcorner"] + 0.5 * g.dy;
  const double no_data = h.values.contains("nodata_value") ? h.values["nodata_value"] : -9999;

  const std::size_t cells = static_cast<std::size_t>(g.nx) * static_cast<std::size_t>(g.ny),
                    found = tokens.size() - h.end;
  if (found != cells) {
    const Token& last = tokens.empty() ? Token{} : tokens[found > cells ? h.end + cells : tokens.size() - 1];
    errors.fail(last.line, last.column,
                "the header says " + std::to_string(g.ny) + " x " + std::to_string(g.nx) + " = " +
                    std::to_string(cells) + " cells, the file has " + std::to_string(found));
  }
  g.z.resize(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    const Token& t = tokens[h.end + i];
    const std::size_t row = i / static_cast<std::size_t>(g.nx), column = i % static_cast<std::size_t>(g.nx);
    const auto x = parse_number(t.text);
    const std::string where = "row " + std::to_string(row + 1) + ", column " + std::to_string(column + 1) + ": ";
    if (!x)
      errors.add(t.line, t.column,
                 where + "'" + std::string(t.text.substr(0, 40)) + "' is not a finite number" + no_height_remedy);
    else if (*x != no_data && std::abs(*x) > farthest / height_unit)
      errors.add(t.line, t.column, where + out_of_range(t.text, farthest / height_unit));
    else if (*x == no_data)
      errors.add(t.line, t.column,
                 where + "the cell has no data (" + std::string(t.text) + "); fill the grid before using it as ground");
    else
      g.z[(static_cast<std::size_t>(g.ny) - 1 - row) * static_cast<std::size_t>(g.nx) + column] = *x * height_unit;
  }
  errors.check();
  return g;
}

HeightGrid read_height_csv(const std::filesystem::path& file, double spacing, double height_unit) {
  const CsvTable t = read_csv(file, false, farthest / height_unit, farthest / height_unit);
  if (t.rows < 2 || t.columns < 2)
    throw ConfigError(
        file.string(), t.line[0], 1,
        "a height map needs at least 2 x 2 cells, got " + std::to_string(t.rows) + " x " + std::to_string(t.columns));
  HeightGrid g{t.columns, t.rows, 0, 0, spacing, spacing, {}};
  g.z.resize(t.cells.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(t.rows); ++row)
    for (std::size_t c = 0; c < static_cast<std::size_t>(t.columns); ++c)
      g.z[(static_cast<std::size_t>(t.rows) - 1 - row) * static_cast<std::size_t>(t.columns) + c] =
          t.cells[row * static_cast<std::size_t>(t.columns) + c] * height_unit;
  return g;
}

}  // namespace grouser
