// URDF (robot description of ROS): links, inertials, joints, visuals. tinyxml2 parses and knows lines; the column is
// that of the element.
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "grouser/terrain/csv.h"
#include "vehicle_reader.h"

namespace grouser::vehicle {

namespace {

using tinyxml2::XMLElement;

constexpr double largest = 1e12, farthest = 1e3;  // beyond any vehicle: a wrong unit or exponent

/// Stops of a URDF joint are hard; here they are springs of this stiffness.
constexpr double stop_stiffness_turn = 2000, stop_stiffness_travel = 1e5;  // [N m/rad], [N/m]

/// What is wrong and how to write it, in place of the parser's symbol.
std::string xml_fault(const tinyxml2::XMLDocument& doc, const std::string& text, const std::string& line) {
  if (const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
      first != std::string::npos && text[first] != '<')
    return "the file begins with other text; a URDF file begins with <?xml ...?> or <robot name=\"...\">";
  const std::string shown = line.size() > 50 ? line.substr(0, 50) + "..." : line;
  const std::string said = doc.ErrorStr() ? doc.ErrorStr() : "";
  const auto named = said.rfind("name=");
  const std::string name = named == std::string::npos ? "" : said.substr(named + 5);
  const std::string at = name.empty() ? "a tag" : "<" + name + ">";
  switch (doc.ErrorID()) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return at + " is opened here and not closed, or closed by a tag of another name; write </" + name + ">";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT:
      return at + " is broken in '" + shown + "'; write <name ...> with </name> after its content, or <name .../>";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute of " + at + " is broken; write name=\"value\"";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "the comment that opens here is not closed; it ends with -->";
    case tinyxml2::XML_ERROR_PARSING_TEXT:
      return "text that no tag closes; each <name> wants its </name>";
    case tinyxml2::XML_ERROR_PARSING_DECLARATION:
      return "<?xml ...?> is allowed once, before everything else, and ends with ?>; is a second file appended here?";
    case tinyxml2::XML_ERROR_PARSING_UNKNOWN:
    case tinyxml2::XML_ERROR_PARSING_CDATA:
      return "the <!...> that opens in '" + shown + "' is not closed; remove it, or end it with >";
    case tinyxml2::XML_ERROR_PARSING:
      return "the tag that opens in '" + shown +
             "' is not closed before the file ends; write </name> behind its content";
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "the file is empty; a URDF file begins with <robot name=\"...\">";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return "tags nested too deep";
    default:
      return said;
  }
}

class Reader {
 public:
  Reader(std::string file, const std::string& text, InputLog& log) : file_(std::move(file)), log_(log) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }

  Place place(const XMLElement* e) const {
    const int line = e->GetLineNum();
    int column = 1;
    if (line >= 1 && line <= static_cast<int>(lines_.size())) {
      const auto at = lines_[line - 1].find("<" + std::string(e->Name()));
      if (at != std::string::npos) column = static_cast<int>(at) + 1;
    }
    return {file_, line, column};
  }
  /// A line without the blanks around it.
  std::string line(int number) const {
    if (number < 1 || number > static_cast<int>(lines_.size())) return "";
    const std::string& l = lines_[number - 1];
    const std::size_t first = l.find_first_not_of(" \t\r");
    return first == std::string::npos ? "" : l.substr(first, l.find_last_not_of(" \t\r") + 1 - first);
  }
  /// First character of a line, for what has no element yet.
  Place line_start(int line) const {
    line = std::clamp(line, 1, std::max(1, static_cast<int>(lines_.size())));
    const std::size_t first = lines_.empty() ? 0 : lines_[line - 1].find_first_not_of(" \t");
    return {file_, line, first == std::string::npos ? 1 : static_cast<int>(first) + 1};
  }
  void error(const XMLElement* e, const std::string& message) {
    const Place p = place(e);
    log_.error(p.file, p.line, p.column, message);
  }
  std::string name(const XMLElement* e, const char* attribute = "name") {
    const char* a = e->Attribute(attribute);
    if (!a || !*a) error(e, std::string("<") + e->Name() + "> needs the attribute '" + attribute + "'");
    return a ? a : "";
  }
  double number(const XMLElement* e, const char* attribute, double fallback, bool required) {
    const char* a = e->Attribute(attribute);
    if (!a) {
      if (required) error(e, std::string("<") + e->Name() + "> needs the attribute '" + attribute + "'");
      return fallback;
    }
    char* end = nullptr;
    const double x = std::strtod(a, &end);
    if (end == a || *end != '\0' || !std::isfinite(x) || std::abs(x) > largest) {
      error(e, std::string("attribute '") + attribute + "' of <" + e->Name() +
                   "> must be a number alone, in SI units, of at most 1e12, got '" + a + "'");
      return fallback;
    }
    return x;
  }
  Vec3 triple(const XMLElement* e, const char* attribute, const Vec3& fallback) {
    const char* a = e ? e->Attribute(attribute) : nullptr;
    if (!a) return fallback;
    std::istringstream in(a);
    Vec3 x;
    std::string rest;
    if (!(in >> x.x() >> x.y() >> x.z()) || (in >> rest) || !x.allFinite() || x.cwiseAbs().maxCoeff() > farthest) {
      error(e, std::string("attribute '") + attribute + "' of <" + e->Name() +
                   "> must be three numbers, each of at most 1000, as in '0 0 1', got '" + a + "'");
      return fallback;
    }
    return x;
  }
  Pose origin(const XMLElement* parent) {
    const XMLElement* e = parent->FirstChildElement("origin");
    const Vec3 a = triple(e, "rpy", Vec3::Zero());
    return {triple(e, "xyz", Vec3::Zero()), Quat(Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()) *
                                                 Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
                                                 Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()))};
  }
  /// Elements outside `known` are errors: a misspelt one would otherwise be lost without a word.
  void only(const XMLElement* e, const std::vector<std::string>& known) {
    for (const XMLElement* c = e->FirstChildElement(); c; c = c->NextSiblingElement())
      if (index_of(c->Name(), known) < 0)
        error(c, unknown_name(std::string("element in <") + e->Name() + ">", c->Name(), known));
  }

 private:
  std::string file_;
  InputLog& log_;
  std::vector<std::string> lines_;
};

std::string defined_twice(const char* what, const std::string& name, int first) {
  return std::string(what) + " '" + name + "' is defined twice, first in line " + std::to_string(first) +
         "; rename or remove one of the two";
}

/// Where a <!DOCTYPE begins that is no comment's: what it defines would be lost without a word.
std::optional<std::size_t> find_doctype(const std::string& text) {
  for (std::size_t at = text.find("<!DOCTYPE"); at != std::string::npos; at = text.find("<!DOCTYPE", at + 1)) {
    const std::size_t comment = text.rfind("<!--", at), end = text.rfind("-->", at);
    if (comment == std::string::npos || (end != std::string::npos && end > comment)) return at;
  }
  return std::nullopt;
}

struct UrdfLink {
  const XMLElement* e = nullptr;
  Pose X_VL;  ///< link frame in V
  bool placed = false;
};

void read_link(Reader& rd, const XMLElement* e, LinkSpec& l, Pose& X_LB) {
  l.name = rd.name(e);
  rd.only(e, {"inertial", "visual", "collision", "contact", "self_collision_checking"});
  if (const XMLElement* in = e->FirstChildElement("inertial")) {
    rd.only(in, {"origin", "mass", "inertia"});
    X_LB = rd.origin(in);
    const XMLElement *m = in->FirstChildElement("mass"), *I = in->FirstChildElement("inertia");
    if (!m)
      rd.error(in, "<inertial> needs <mass value=\"...\"/> [kg]");
    else if (l.mass = rd.number(m, "value", 0, true); l.mass < 0)
      rd.error(m, std::string("the mass must not be negative [kg], got '") + m->Attribute("value") +
                      "'; give what the body weighs, 0 only for one that is fixed to another");
    if (!I) {
      rd.error(in, "<inertial> needs <inertia ixx= iyy= izz= ixy= ixz= iyz=> [kg m^2]");
    } else {
      const double xx = rd.number(I, "ixx", 0, true), yy = rd.number(I, "iyy", 0, true),
                   zz = rd.number(I, "izz", 0, true);
      const double xy = rd.number(I, "ixy", 0, false), xz = rd.number(I, "ixz", 0, false),
                   yz = rd.number(I, "iyz", 0, false);
      l.inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    }
  }
  for (const XMLElement* v = e->FirstChildElement("visual"); v; v = v->NextSiblingElement("visual")) {
    const XMLElement* g = v->FirstChildElement("geometry");
    if (!g) {
      rd.error(v, "<visual> needs <geometry>");
      continue;
    }
    rd.only(g, {"box", "cylinder", "sphere", "mesh"});
    Visual s;
    s.X_BS = X_LB.inverse() * rd.origin(v);
    if (const XMLElement* b = g->FirstChildElement("box")) {
      s.size = rd.triple(b, "size", Vec3::Zero());
    } else if (const XMLElement* c = g->FirstChildElement("cylinder")) {
      s.kind = Visual::Kind::cylinder;
      s.size = Vec3(rd.number(c, "radius", 0, true), rd.number(c, "length", 0, true), 0);
      // A URDF cylinder lies along z, ours along y.
      s.X_BS.q = s.X_BS.q * Quat(Eigen::AngleAxisd(0.5 * pi, Eigen::Vector3d::UnitX()));
    } else {
      continue;  // spheres and meshes are not shown
    }
    l.visuals.push_back(s);
  }
}

}  // namespace

void read_urdf_vehicle(const std::filesystem::path& file, const ConfigNode& extras, ReadVehicle& r, InputLog& log) {
  VehicleSpec& v = r.spec;
  std::string text;
  try {
    text = read_text_file(file);
  } catch (const ConfigError& e) {
    log.errors.insert(log.errors.end(), e.diagnostics().begin(), e.diagnostics().end());
    return;
  }
  Reader rd(file.string(), text, log);
  if (const auto at = find_doctype(text)) {
    const Place p = rd.line_start(
        1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(*at), '\n')));
    log.error(
        p.file, p.line, p.column,
        "<!DOCTYPE ...> is not read: the entities and defaults in it would be lost; write them out and remove it");
    return;
  }
  tinyxml2::XMLDocument doc;
  if (doc.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS) {
    const Place p = rd.line_start(doc.ErrorLineNum());
    log.error(p.file, p.line, p.column, "not well-formed XML: " + xml_fault(doc, text, rd.line(p.line)));
    return;
  }
  const XMLElement* robot = doc.FirstChildElement("robot");
  if (!robot) {
    const XMLElement* root = doc.RootElement();
    const Place p = root ? rd.place(root) : Place{file.string(), 1, 1};
    log.error(p.file, p.line, p.column,
              std::string("a URDF file has the root element <robot name=\"...\">") +
                  (root ? std::string("; here it is <") + root->Name() + ">" : ""));
    return;
  }
  if (robot->Attribute("xmlns:xacro")) {
    rd.error(robot, "this is a xacro file; write the URDF with 'xacro FILE > robot.urdf' and give that");
    return;
  }
  v.name = rd.name(robot);
  rd.only(robot, {"link", "joint", "material", "gazebo", "transmission"});

  std::vector<UrdfLink> frames;
  std::vector<Pose> X_LB;
  for (const XMLElement* e = robot->FirstChildElement("link"); e; e = e->NextSiblingElement("link")) {
    LinkSpec l;
    Pose X;
    read_link(rd, e, l, X);
    if (const int first = index_of(l.name, link_names(v)); first >= 0)
      rd.error(e, defined_twice("link", l.name, r.link_place[static_cast<std::size_t>(first)].line));
    v.links.push_back(l);
    X_LB.push_back(X);
    UrdfLink f;
    f.e = e;
    frames.push_back(f);
    r.link_place.push_back(rd.place(e));
  }

  const std::vector<std::string> links = link_names(v);
  std::vector<Pose> X_PJ;  // joint frame in the parent link's frame
  std::vector<Vec3> axis_J;
  for (const XMLElement* e = robot->FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
    JointSpec j;
    j.name = rd.name(e);
    if (const int first = index_of(j.name, joint_names(v)); first >= 0)
      rd.error(e, defined_twice("joint", j.name, r.joint_place[static_cast<std::size_t>(first)].line));
    rd.only(e, {"origin", "parent", "child", "axis", "calibration", "dynamics", "limit", "mimic", "safety_controller"});
    const std::string type = rd.name(e, "type");
    if (index_of(type, {"revolute", "continuous", "prismatic", "fixed"}) < 0)
      rd.error(e, unknown_name("joint type", type, {"revolute", "continuous", "prismatic", "fixed"}));
    j.type = type == "prismatic" ? JointSpec::Type::prismatic : JointSpec::Type::revolute;
    auto end = [&](const char* which) {
      const XMLElement* c = e->FirstChildElement(which);
      if (!c) {
        rd.error(e, std::string("joint '") + j.name + "' needs <" + which + " link=\"...\"/>");
        return -1;
      }
      const std::string n = rd.name(c, "link");
      const int i = index_of(n, links);
      if (i < 0) rd.error(c, unknown_name(std::string(which) + " link", n, links));
      return i;
    };
    j.parent = end("parent");
    j.child = end("child");
    const XMLElement* ax = e->FirstChildElement("axis");
    Vec3 axis = rd.triple(ax, "xyz", Vec3::UnitX());
    if (axis.norm() < 1e-9) rd.error(ax, "the axis must not be zero; for example xyz=\"0 1 0\""), axis = Vec3::UnitX();
    if (const XMLElement* m = e->FirstChildElement("mimic"))
      rd.error(m, "mimic joints are not supported; use 'differential' in the scenario for a rocker-bogie");
    if (const XMLElement* d = e->FirstChildElement("dynamics")) {
      j.damping = rd.number(d, "damping", 0, false);
      if (j.damping < 0) rd.error(d, "damping must not be negative");
      if (rd.number(d, "friction", 0, false) != 0)
        rd.error(d, "dry joint friction is not modelled; use damping and set friction to 0");
    }
    if (const XMLElement* l = e->FirstChildElement("limit"); l && (type == "revolute" || type == "prismatic")) {
      StopSpec s;
      s.lower = rd.number(l, "lower", 0, false);
      s.upper = rd.number(l, "upper", 0, false);
      s.stiffness = j.type == JointSpec::Type::revolute ? stop_stiffness_turn : stop_stiffness_travel;
      if (!(s.lower < s.upper)) rd.error(l, "'lower' must be below 'upper'");
      const bool turn = j.type == JointSpec::Type::revolute;
      log.assumptions.push_back({file.string(), "joint " + j.name + ".limit stiffness",
                                 turn ? "2000 N m/rad" : "1e5 N/m",
                                 "URDF limits are rigid; a spring stop needs a stiffness"});
      j.stops = s;
    } else if (type == "revolute" && !l) {
      rd.error(e, "a revolute joint needs <limit lower= upper=>; use type=\"continuous\" for a wheel");
    }
    if (j.parent < 0 || j.child < 0) continue;
    v.joints.push_back(j);
    X_PJ.push_back(rd.origin(e));
    axis_J.push_back(axis.normalized());
    r.joint_place.push_back(rd.place(e));
    r.fixed.push_back(type == "fixed");
  }

  // Frames from the root down; a loop or a second parent leaves links unplaced and is reported by the common check.
  std::vector<bool> is_child(links.size(), false);
  for (const JointSpec& j : v.joints) is_child[j.child] = true;
  for (std::size_t i = 0; i < links.size(); ++i) frames[i].placed = !is_child[i];
  for (bool more = true; more;) {
    more = false;
    for (std::size_t k = 0; k < v.joints.size(); ++k) {
      JointSpec& j = v.joints[k];
      if (!frames[j.parent].placed || frames[j.child].placed) continue;
      frames[j.child].X_VL = frames[j.parent].X_VL * X_PJ[k];
      frames[j.child].placed = more = true;
      j.anchor_V = frames[j.child].X_VL.p;
      j.axis_V = frames[j.child].X_VL.q * axis_J[k];
    }
  }
  for (std::size_t i = 0; i < links.size(); ++i) v.links[i].X_VB = frames[i].X_VL * X_LB[i];

  // What URDF does not say.
  read_motors(extras, v);
  std::map<std::string, RunningGear> gears;
  const ConfigNode wheels = extras.map("wheels");
  for (const std::string& name : wheels.keys()) {
    const ConfigNode n = wheels.map(name);
    WheelSpec w;
    w.name = name;
    w.link = index_of(name, links);
    w.gear = read_gear(n, gears, log);
    w.motor = read_wheel_motor(n, v);
    n.finish();
    if (w.link < 0) {
      n.error(unknown_name("wheel link", name, links));
      continue;
    }
    for (std::size_t k = 0; k < v.joints.size(); ++k)
      if (v.joints[k].child == w.link && !r.fixed[k]) w.joint = static_cast<int>(k);
    if (w.joint < 0 || v.joints[w.joint].type != JointSpec::Type::revolute) {
      n.error("link '" + name + "' is not the child of a continuous or revolute joint: a wheel needs an axle");
      continue;
    }
    JointSpec& axle = v.joints[w.joint];
    if (axle.axis_V.y() < 0) axle.axis_V = -axle.axis_V;  // positive rotation = driving forward
    w.left = v.links[w.link].X_VB.p.y() > 0;
    v.wheels.push_back(std::move(w));
  }
  read_drive_train(extras, v);
}

}  // namespace grouser::vehicle
