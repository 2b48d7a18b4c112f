#include <algorithm>
#include <fstream>
#include <sstream>

#include "grouser/terrain/markup.h"
#include "grouser/terrain/recorder.h"

namespace grouser {

namespace {

// At most this many frames: XDMF is text, 20 kB per frame, and a film needs no more. The frames between are in run.h5.
constexpr std::uint64_t most_frames = 1000;

/// One body: where it is and what is shown there.
struct Point {
  std::string name;
  std::string position;  // dataset
  std::vector<ChannelSpec> values;
};

std::vector<Point> points_of(const RunFile& run) {
  std::vector<Point> points;
  const auto channels = run.channels();
  auto add = [&](const std::string& suffix) {
    for (const ChannelSpec& c : channels) {
      if (c.components != 3 || !c.name.ends_with(suffix)) continue;
      const std::string name = c.name.substr(0, c.name.size() - suffix.size());
      const bool known = std::any_of(points.begin(), points.end(), [&](const Point& p) { return p.name == name; });
      if (!known) points.push_back({name, c.name, {}});
    }
  };
  add(".position");
  add(".contact_point");  // wheels that are not bodies of their own
  static const std::vector<std::string> shown{"force", "sinkage", "slip", "normal_force", "drawbar_pull"};
  for (Point& p : points)
    for (const std::string& what : shown)
      for (const ChannelSpec& c : channels)
        if (c.name == p.name + "." + what && (c.components == 1 || c.components == 3)) p.values.push_back(c);
  return points;
}

class Writer {
 public:
  Writer(std::ostream& o, std::string h5, std::uint64_t frames) : out_(o), h5_(std::move(h5)), frames_(frames) {}

  /// One row of a channel.
  void row(const std::string& dataset, int components, std::uint64_t frame) {
    if (components == 1)
      out_ << "<DataItem ItemType=\"HyperSlab\" Dimensions=\"1\"><DataItem Dimensions=\"3 1\" Format=\"XML\">" << frame
           << " 1 1</DataItem><DataItem Dimensions=\"" << frames_ << "\"";
    else
      out_ << "<DataItem ItemType=\"HyperSlab\" Dimensions=\"1 " << components
           << "\"><DataItem Dimensions=\"3 2\" Format=\"XML\">" << frame << " 0 1 1 1 " << components
           << "</DataItem><DataItem Dimensions=\"" << frames_ << ' ' << components << "\"";
    out_ << " NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">" << markup_escaped(h5_) << ":/"
         << markup_escaped(dataset) << "</DataItem></DataItem>";
  }

  void point(const Point& p, std::uint64_t frame) {
    out_ << "<Grid Name=\"" << markup_escaped(p.name)
         << "\" GridType=\"Uniform\"><Topology TopologyType=\"Polyvertex\" NumberOfElements=\"1\" "
         << "NodesPerElement=\"1\"/><Geometry GeometryType=\"XYZ\">";
    row(p.position, 3, frame);
    out_ << "</Geometry>\n";
    for (const ChannelSpec& c : p.values) {
      const std::string what = c.name.substr(p.name.size() + 1) + " [" + c.unit + "]";
      out_ << "<Attribute Name=\"" << markup_escaped(what) << "\" AttributeType=\""
           << (c.components == 1 ? "Scalar" : "Vector") << "\" Center=\"Node\">";
      row(c.name, c.components, frame);
      out_ << "</Attribute>\n";
    }
    out_ << "</Grid>\n";
  }

  void whole(const std::string& dataset, const std::string& dims) {
    out_ << "<DataItem Dimensions=\"" << dims << "\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">"
         << markup_escaped(h5_) << ":/" << dataset << "</DataItem>";
  }

  void ground(std::uint64_t nx, std::uint64_t ny) {
    const std::string x = std::to_string(nx), y = std::to_string(ny);
    out_ << "<Grid Name=\"ground\" GridType=\"Uniform\"><Topology TopologyType=\"3DRectMesh\" Dimensions=\"1 " << y
         << ' ' << x << "\"/><Geometry GeometryType=\"VXVYVZ\">";
    whole("ground.x", x);
    whole("ground.y", y);
    out_ << "<DataItem Dimensions=\"1\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">0</DataItem></Geometry>\n"
         << "<Attribute Name=\"height [m]\" AttributeType=\"Scalar\" Center=\"Node\">";
    whole("ground.height", "1 " + y + ' ' + x);
    out_ << "</Attribute>\n</Grid>\n";
  }

 private:
  std::ostream& out_;
  std::string h5_;
  std::uint64_t frames_;
};

}  // namespace

void write_xdmf(const std::filesystem::path& run_file, const std::filesystem::path& xdmf_file) {
  const RunFile run(run_file);
  const std::vector<double> time = run.time();
  const std::vector<Point> points = points_of(run);
  std::error_code ec;
  std::filesystem::path h5 =
      std::filesystem::relative(run_file, xdmf_file.has_parent_path() ? xdmf_file.parent_path() : ".", ec);
  if (ec || h5.empty()) h5 = run_file;

  std::ofstream out(xdmf_file);
  Writer w(out, h5.string(), run.frames());
  const std::uint64_t stride = std::max<std::uint64_t>(1, (time.size() + most_frames - 1) / most_frames);
  out << "<?xml version=\"1.0\" ?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\"><Domain>\n"
      << "<Information Name=\"title\" Value=\"" << markup_escaped(run.attributes().title) << "\"/>\n"
      << "<Information Name=\"frame stride\" Value=\"" << stride << "\"/>\n"
      << "<Grid Name=\"run\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  std::vector<std::uint64_t> ground;
  const bool has_ground = run.has("ground.x") && run.has("ground.y") && run.has("ground.height");
  if (has_ground) run.read("ground.height", &ground);
  for (std::uint64_t i = 0; i < time.size(); i += stride) {
    std::ostringstream t;
    t.precision(17);
    t << time[i];
    out << "<Grid Name=\"frame " << i << "\" GridType=\"Collection\" CollectionType=\"Spatial\"><Time Value=\""
        << t.str() << "\"/>\n";
    for (const Point& p : points) w.point(p, i);
    if (has_ground && ground.size() == 2) w.ground(ground[1], ground[0]);
    out << "</Grid>\n";
  }
  out << "</Grid>\n</Domain></Xdmf>\n";
  out.flush();
  if (!out)
    throw ResultsError(xdmf_file.string() + ": cannot be written; is the folder writable and the disk not full?");
}

}  // namespace grouser
