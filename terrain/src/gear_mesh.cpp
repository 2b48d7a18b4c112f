#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "grouser/terrain/mesh_file.h"
#include "units.h"

namespace grouser {
namespace {

constexpr std::size_t shown = 5;  // faults of one kind that are listed

struct Triangle {
  std::array<std::int32_t, 3> v;
  int line;  ///< in the file; for binary STL the number of the triangle
};

struct RawMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  bool binary = false;
};

class Faults {
 public:
  Faults(std::string file, std::vector<Diagnostic>& out) : file_(std::move(file)), out_(out) {}
  void at(int line, const std::string& message) {
    ++count_;
    const std::size_t n = ++kinds_[message.substr(0, message.find('\''))];
    if (n <= shown) out_.push_back({file_, line, line > 0 ? 1 : 0, message});
  }
  void triangle(const RawMesh& m, const Triangle& t, const std::string& message) {
    if (m.binary)
      at(0, "triangle " + std::to_string(t.line) + ": " + message);
    else
      at(t.line, message);
  }
  bool none() const { return count_ == 0; }

 private:
  std::string file_;
  std::vector<Diagnostic>& out_;
  std::map<std::string, std::size_t> kinds_;
  std::size_t count_ = 0;
};

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> out;
  for (std::string w; in >> w;) out.push_back(w);
  return out;
}

/// Three numbers from words[at...].
bool three(const std::vector<std::string>& w, std::size_t at, Vec3& v) {
  if (w.size() < at + 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& s = w[at + i];
    const char* begin = s.data() + (s[0] == '+' ? 1 : 0);
    double x = 0;
    const auto r = std::from_chars(begin, s.data() + s.size(), x);
    if (r.ec != std::errc() || r.ptr != s.data() + s.size() || !std::isfinite(x)) return false;
    v[static_cast<int>(i)] = x;
  }
  return true;
}

RawMesh read_obj(const std::string& text, Faults& faults) {
  static const std::set<std::string> ignored{"vn", "vt", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p"};
  RawMesh m;
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const auto w = words(line.substr(0, line.find('#')));
    if (w.empty() || ignored.count(w[0]) != 0) continue;
    if (w[0] == "v") {
      Vec3 v = Vec3::Zero();
      if (!three(w, 1, v)) faults.at(number, "a vertex is 'v x y z' with three finite numbers");
      m.vertices.push_back(v);
    } else if (w[0] == "f") {
      std::vector<std::int32_t> corners;
      bool good = w.size() >= 4;
      if (!good) faults.at(number, "a face has at least three vertices");
      for (std::size_t i = 1; i < w.size() && good; ++i) {
        // "7", "7/1", "7//3"; a negative index counts back from the last vertex.
        const std::string index = w[i].substr(0, w[i].find('/'));
        long k = 0;
        const auto r = std::from_chars(index.data(), index.data() + index.size(), k);
        const long count = static_cast<long>(m.vertices.size());
        const bool number_read = r.ec == std::errc() && r.ptr == index.data() + index.size();
        if (number_read && k < 0) k = count + 1 + k;
        good = number_read && k >= 1 && k <= count;
        if (good)
          corners.push_back(static_cast<std::int32_t>(k - 1));
        else
          faults.at(number, "bad vertex index '" + w[i] + "'; " + std::to_string(count) +
                                " vertices are known above this line");
      }
      for (std::size_t i = 2; i < corners.size() && good; ++i)
        m.triangles.push_back({{corners[0], corners[i - 1], corners[i]}, number});
    } else {
      faults.at(number, "unknown OBJ keyword '" + w[0] +
                            "'; known are v, f and what is not needed (vn, vt, g, o, s, usemtl, mtllib)");
    }
  }
  return m;
}

RawMesh read_ascii_stl(const std::string& text, Faults& faults) {
  RawMesh m;
  std::istringstream in(text);
  std::string line;
  int corners = 0, number = 1, facet = 0;
  bool closed = false;
  for (; std::getline(in, line); ++number) {
    const auto w = words(line);
    if (w.empty() || w[0] == "solid" || w[0] == "outer" || w[0] == "endloop") continue;
    if (w[0] == "endsolid") {
      closed = true;
    } else if (w[0] == "facet") {
      corners = 0;
      facet = number;
    } else if (w[0] == "vertex") {
      Vec3 v = Vec3::Zero();
      if (!three(w, 1, v)) faults.at(number, "a vertex is 'vertex x y z' with three finite numbers");
      m.vertices.push_back(v);
      ++corners;
    } else if (w[0] == "endfacet") {
      const auto last = static_cast<std::int32_t>(m.vertices.size()) - 1;
      if (corners == 3)
        m.triangles.push_back({{last - 2, last - 1, last}, facet});
      else
        faults.at(number, "a facet has three vertices");
    } else {
      faults.at(number, "unknown STL keyword '" + w[0] +
                            "'; known are solid, facet, outer, vertex, endloop, endfacet, endsolid");
    }
  }
  if (!closed) faults.at(number, "the file ends before 'endsolid': it is cut off; export the mesh again");
  return m;
}

RawMesh read_binary_stl(const std::string& bytes, Faults& faults) {
  RawMesh m;
  m.binary = true;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<float, 12> f{};
    std::memcpy(f.data(), bytes.data() + 84 + 50 * static_cast<std::size_t>(i), 48);
    const auto first = static_cast<std::int32_t>(m.vertices.size());
    const Triangle t{{first, first + 1, first + 2}, static_cast<int>(i) + 1};
    bool finite = true;
    for (std::size_t k = 3; k < 12; k += 3) {
      m.vertices.emplace_back(f[k], f[k + 1], f[k + 2]);
      finite = finite && m.vertices.back().allFinite();
    }
    if (!finite) faults.triangle(m, t, "a coordinate is not a finite number; export the mesh again");
    m.triangles.push_back(t);
  }
  return m;
}

/// Same position, same vertex: STL repeats every corner, and some OBJ writers repeat those along seams.
void join_equal(RawMesh& m) {
  std::map<std::array<double, 3>, std::int32_t> known;
  std::vector<std::int32_t> to(m.vertices.size());
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < m.vertices.size(); ++i) {
    const Vec3& v = m.vertices[i];
    // -0.0 and 0.0 are one place.
    const auto [it, fresh] = known.emplace(std::array<double, 3>{v.x() + 0.0, v.y() + 0.0, v.z() + 0.0},
                                           static_cast<std::int32_t>(kept.size()));
    if (fresh) kept.push_back(v);
    to[i] = it->second;
  }
  for (Triangle& t : m.triangles)
    for (std::int32_t& v : t.v) v = to[static_cast<std::size_t>(v)];
  m.vertices = std::move(kept);
}

void check_surface(const RawMesh& m, Faults& faults) {
  double size = 0, volume = 0;
  for (const Vec3& v : m.vertices) size = std::max(size, v.cwiseAbs().maxCoeff());
  std::map<std::pair<std::int32_t, std::int32_t>, const Triangle*> edges;
  const auto at = [&](std::int32_t i) -> const Vec3& { return m.vertices[static_cast<std::size_t>(i)]; };
  for (const Triangle& t : m.triangles) {
    const Vec3 &a = at(t.v[0]), &b = at(t.v[1]), &c = at(t.v[2]);
    if ((b - a).cross(c - a).norm() < 1e-12 * size * size) {
      faults.triangle(m, t, "degenerate triangle: its corners lie on one line");
      continue;
    }
    volume += a.dot(b.cross(c)) / 6;
    for (std::size_t k = 0; k < 3; ++k)
      if (!edges.emplace(std::pair{t.v[k], t.v[(k + 1) % 3]}, &t).second)
        faults.triangle(
            m, t, "an edge is used twice in the same direction: neighbours face opposite ways or lie on each other");
  }
  if (!faults.none()) return;
  std::size_t open = 0;
  const Triangle* first = nullptr;
  for (const auto& [edge, triangle] : edges) {
    if (edges.count({edge.second, edge.first}) != 0) continue;
    ++open;
    if (first == nullptr || triangle->line < first->line) first = triangle;
  }
  if (open > 0)
    faults.triangle(
        m, *first,
        "the surface is not closed: " + std::to_string(open) + " edges belong to one triangle only; fill the holes");
  else if (volume <= 0)
    faults.at(0, "the triangles face inwards; order their corners counter-clockwise seen from outside");
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file, double scale, std::vector<Diagnostic>& out) {
  Faults faults(file.string(), out);
  TriangleMesh mesh;
  std::ifstream in(file, std::ios::binary);
  std::ostringstream buffer;
  buffer << in.rdbuf();
  const std::string bytes = buffer.str();
  if (!in || bytes.empty()) {
    faults.at(0, "the mesh file is empty or cannot be read");
    return mesh;
  }
  std::string ext = file.extension().string();
  for (char& c : ext) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  RawMesh raw;
  if (ext == ".obj") {
    raw = read_obj(bytes, faults);
  } else if (ext == ".stl") {
    std::uint32_t count = 0;
    if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
    // The length tells binary from text: some binary files begin with "solid" too.
    if (bytes.size() >= 84 && bytes.size() == 84 + 50 * static_cast<std::size_t>(count)) {
      raw = read_binary_stl(bytes, faults);
    } else if (bytes.rfind("solid", 0) == 0 && bytes.find('\0') == std::string::npos) {
      raw = read_ascii_stl(bytes, faults);
    } else {
      faults.at(0, "the STL file is cut off or damaged: " + std::to_string(bytes.size()) +
                       " bytes, its header announces " + std::to_string(count) + " triangles (" +
                       std::to_string(84 + 50 * static_cast<std::size_t>(count)) + " bytes); export the mesh again");
      return mesh;
    }
  } else {
    faults.at(0, "unknown mesh format '" + ext + "'; known are .obj and .stl");
    return mesh;
  }
  if (faults.none() && raw.triangles.empty()) faults.at(0, "the mesh has no triangles");
  if (!faults.none()) return mesh;
  join_equal(raw);
  check_surface(raw, faults);
  for (const Vec3& v : raw.vertices) mesh.vertices.push_back(scale * v);
  for (const Triangle& t : raw.triangles) mesh.triangles.push_back(t.v);
  return mesh;
}

}  // namespace grouser
