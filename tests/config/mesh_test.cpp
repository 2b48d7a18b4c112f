// Wheel meshes: the three formats give the same body, and every fault is named with file and line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "config_support.h"
#include "grouser/terrain/loaders.h"

namespace grouser {
namespace {

using ::testing::ElementsAre;
using testing::messages;

constexpr int sectors = 24;
constexpr double radius = 0.125, width = 0.16;  // exact in single precision: 0.125; the width is rounded there

/// Closed drum with two hub vertices, corners counter-clockwise from outside.
TriangleMesh drum() {
  TriangleMesh m;
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < sectors; ++i) {
      const double a = 2 * pi * i / sectors;
      m.vertices.emplace_back(radius * std::cos(a), side == 0 ? -width / 2 : width / 2, radius * std::sin(a));
    }
  m.vertices.emplace_back(0, -width / 2, 0);
  m.vertices.emplace_back(0, width / 2, 0);
  for (int i = 0; i < sectors; ++i) {
    const int a = i, b = (i + 1) % sectors, c = a + sectors, d = b + sectors;
    m.triangles.push_back({{a, c, b}});
    m.triangles.push_back({{b, c, d}});
    m.triangles.push_back({{2 * sectors, a, b}});
    m.triangles.push_back({{2 * sectors + 1, d, c}});
  }
  return m;
}

class Meshes : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() /
             ("grouser_mesh_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }

  static std::string obj(const TriangleMesh& m) {
    std::string s = "# drum\n";
    char line[128];
    for (const Vec3& v : m.vertices) {
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", v.x(), v.y(), v.z());
      s += line;
    }
    for (const auto& t : m.triangles)
      s += "f " + std::to_string(t[0] + 1) + "//1 " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    return s;
  }
  static std::string ascii_stl(const TriangleMesh& m, double scale) {
    std::string s = "solid drum\n";
    char line[128];
    for (const auto& t : m.triangles) {
      s += "facet normal 0 0 0\nouter loop\n";
      for (const int k : t) {
        const Vec3 v = scale * m.vertices[static_cast<std::size_t>(k)];
        std::snprintf(line, sizeof line, "vertex %.9g %.9g %.9g\n", v.x(), v.y(), v.z());
        s += line;
      }
      s += "endloop\nendfacet\n";
    }
    return s + "endsolid drum\n";
  }
  static std::string binary_stl(const TriangleMesh& m) {
    std::string s(80, ' ');
    s.replace(0, 5, "solid");  // as some programs write it
    const auto put = [&](const void* p, std::size_t n) { s.append(static_cast<const char*>(p), n); };
    const auto count = static_cast<std::uint32_t>(m.triangles.size());
    put(&count, 4);
    for (const auto& t : m.triangles) {
      float f[12] = {};
      for (std::size_t k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c)
          f[3 + 3 * k + static_cast<std::size_t>(c)] =
              static_cast<float>(m.vertices[static_cast<std::size_t>(t[k])][c]);
      put(f, 48);
      put("\0\0", 2);
    }
    return s;
  }
  std::vector<std::string> errors(const std::string& file, const std::string& more = "radius: 125 mm\n") const {
    return messages(
        "wheel: w\nsource: s\nshape: mesh\nfile: " + file + "\n" + more,
        [](const ConfigNode& r) { load_running_gear(r); }, "w.yaml", folder.string());
  }

  std::filesystem::path folder;
};

TEST_F(Meshes, ObjAndBothStlFormatsGiveTheSameDrum) {
  write("d.obj", obj(drum()));
  write("a.stl", ascii_stl(drum(), 1000));
  write("b.stl", binary_stl(drum()));
  for (const std::string file : {"d.obj", "a.stl", "b.stl"}) {
    SCOPED_TRACE(file);
    const ConfigDocument d = ConfigDocument::from_text("wheel: w\nsource: s\nshape: mesh\nfile: " + file + "\nunit: " +
                                                           (file == "a.stl" ? "mm" : "m") + "\nradius: 125 mm\n",
                                                       "w.yaml", folder);
    const RunningGear g = load_running_gear(d.root());
    ASSERT_NO_THROW(d.check());
    const auto& m = std::get<TriangleMesh>(g.shape);
    EXPECT_EQ(m.vertices.size(), 2U * sectors + 2);
    EXPECT_EQ(m.triangles.size(), 4U * sectors);
    // Single precision of the STL files: 1e-7 relative.
    EXPECT_NEAR(m.width, width, 1e-7);
    EXPECT_NEAR(g.outer_radius(), radius, 1e-7);
    double volume = 0;
    for (const auto& t : m.triangles) {
      const Vec3 &a = m.vertices[static_cast<std::size_t>(t[0])], &b = m.vertices[static_cast<std::size_t>(t[1])],
                 &c = m.vertices[static_cast<std::size_t>(t[2])];
      volume += a.dot(b.cross(c)) / 6;
    }
    // Prism over a regular 24-gon: area n/2 r^2 sin(2 pi/n).
    EXPECT_NEAR(volume, 0.5 * sectors * radius * radius * std::sin(2 * pi / sectors) * width, 1e-9);
  }
}

TEST_F(Meshes, PolygonsAndNegativeIndicesAreRead) {
  // A cube of 0.2 m with quads, the last face counted from the end.
  write("cube.obj",
        "v -0.1 -0.1 -0.1\nv 0.1 -0.1 -0.1\nv 0.1 0.1 -0.1\nv -0.1 0.1 -0.1\nv -0.1 -0.1 0.1\nv 0.1 -0.1 0.1\nv 0.1 "
        "0.1 0.1\nv -0.1 0.1 0.1\n"
        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -8 -4 -1 -5\n");
  EXPECT_THAT(errors("cube.obj", "radius: 0.1 m\n"), ::testing::IsEmpty());
}

TEST_F(Meshes, MissingFileIsNamedInTheWheelFile) {
  EXPECT_THAT(errors("gone.obj"),
              ElementsAre("w.yaml:4:7: file: file 'gone.obj' not found; looked for " + at("gone.obj")));
}

TEST_F(Meshes, BadIndexNamesItsLine) {
  write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\nf 1 2\nv 1 x 2\nfoo\n");
  EXPECT_THAT(errors("bad.obj"),
              ElementsAre(at("bad.obj") + ":4:1: bad vertex index '9'; 3 vertices are known above this line",
                          at("bad.obj") + ":5:1: a face has at least three vertices",
                          at("bad.obj") + ":6:1: a vertex is 'v x y z' with three finite numbers",
                          at("bad.obj") + ":7:1: unknown OBJ keyword 'foo'; known are v, f and what is not needed (vn, "
                                          "vt, g, o, s, usemtl, mtllib)"));
}

TEST_F(Meshes, OpenSurfaceDegenerateAndInsideOut) {
  TriangleMesh m = drum();
  m.triangles.pop_back();
  write("open.obj", obj(m));
  // The lost triangle was the last in the file; the first neighbour of the hole is the one before it on the rim.
  const auto open = errors("open.obj");
  ASSERT_EQ(open.size(), 1U);
  EXPECT_THAT(open[0],
              ::testing::HasSubstr("the surface is not closed: 3 edges belong to one triangle only; fill the holes"));

  m = drum();
  m.triangles.push_back({{0, 0, 1}});
  write("flat.obj", obj(m));
  const int last = 1 + 2 * sectors + 2 + 4 * sectors + 1;
  EXPECT_THAT(errors("flat.obj"), ElementsAre(at("flat.obj") + ":" + std::to_string(last) +
                                              ":1: degenerate triangle: its corners lie on one line"));

  m = drum();
  for (auto& t : m.triangles) std::swap(t[1], t[2]);
  write("inward.stl", binary_stl(m));
  EXPECT_THAT(errors("inward.stl"),
              ElementsAre(at("inward.stl") +
                          ": the triangles face inwards; order their corners counter-clockwise seen from outside"));

  m = drum();
  std::swap(m.triangles[7][1], m.triangles[7][2]);
  write("mixed.stl", binary_stl(m));
  const auto mixed = errors("mixed.stl");
  ASSERT_FALSE(mixed.empty());
  EXPECT_THAT(mixed[0],
              ::testing::HasSubstr(
                  "an edge is used twice in the same direction: neighbours face opposite ways or lie on each other"));
}

TEST_F(Meshes, EmptyCutOffAndUnknownFiles) {
  write("none.obj", "v 0 0 0\n");
  EXPECT_THAT(errors("none.obj"), ElementsAre(at("none.obj") + ": the mesh has no triangles"));
  write("zero.obj", "");
  EXPECT_THAT(errors("zero.obj"), ElementsAre(at("zero.obj") + ": the mesh file is empty or cannot be read"));
  const std::string whole = binary_stl(drum());
  write("cut.stl", whole.substr(0, 1000));
  EXPECT_THAT(
      errors("cut.stl"),
      ElementsAre(at("cut.stl") +
                  ": the STL file is cut off or damaged: 1000 bytes, its header announces 96 triangles (4884 bytes); "
                  "export the mesh again"));
  const std::string text = ascii_stl(drum(), 1);
  write("cut_text.stl", text.substr(0, text.rfind("endsolid")));
  EXPECT_THAT(errors("cut_text.stl").at(0),
              ::testing::HasSubstr("the file ends before 'endsolid': it is cut off; export the mesh again"));
  write("w.ply", "ply\n");
  EXPECT_THAT(errors("w.ply"), ElementsAre(at("w.ply") + ": unknown mesh format '.ply'; known are .obj and .stl"));
}

TEST_F(Meshes, WrongUnitIsExplained) {
  write("d.obj", obj(drum()));
  EXPECT_THAT(errors("d.obj", "unit: mm\nradius: 125 mm\n"),
              ElementsAre("w.yaml:6:9: radius: the mesh reaches 0.125 mm from its y axis (spin axis); the nominal "
                          "radius lies between half of that "
                          "and that: check 'unit: mm' and the axes of the mesh"));
}

}  // namespace
}  // namespace grouser
