// With cad_crossings, cad_face and cad_names, the only files that use OpenCASCADE.
#include "shell/io/cad_file.h"

#ifndef SUNDER_CAD

namespace sunder::shell {

struct CadFile::Shape {
  std::string unit;
};

CadFile::CadFile(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace&) {
  scene.fail(field,
             "this build has no OpenCASCADE, which reads STEP and IGES; `coupler/sunder` of a checkout builds with it "
             "where SUNDER_BUILD_DIR is unset");
}
int CadFile::faces() const { return 0; }
std::vector<CadSurface> CadFile::surfaces(const scene::LoadedScene& scene, const std::string& field,
                                          const proto::CadFace&) const {
  scene.fail(field, "this build has no OpenCASCADE");
}
std::vector<CadEdge> CadFile::edges() const { return {}; }
const std::vector<NamedCadFaces>& CadFile::bodies() const {
  static const std::vector<NamedCadFaces> none;
  return none;
}
const std::vector<NamedCadFaces>& CadFile::layers() const { return bodies(); }
std::vector<int> CadFile::chosen(const scene::LoadedScene& scene, const std::string& field,
                                 const proto::CadFace&) const {
  scene.fail(field, "this build has no OpenCASCADE");
}
std::string CadFile::kind(int) const { return {}; }
const std::string& CadFile::unit() const { return shape_->unit; }
std::pair<Vec3, Vec3> CadFile::box() const { return {}; }

}  // namespace sunder::shell

#else

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <new>
#include <numeric>
#include <set>
#include <sstream>
#include <system_error>
#include <tuple>

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GCPnts_AbscissaPoint.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_BasicEditor.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Check.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Trsf.hxx>

#include "coupler/core/nearest.h"
#include "shell/io/cad_crossings.h"
#include "shell/io/cad_face.h"
#include "shell/io/cad_names.h"
#include "shell/io/cad_trial.h"

namespace sunder::shell {
namespace {

constexpr int kStretches = 16;        // of an edge that is no line, between points that tell its course
constexpr double kMostTrialS = 60.0;  // of processor time that a file may take to be read and converted [s]

/// Silences OpenCASCADE, which prints to the caller's standard output.
class Quiet {
 public:
  Quiet() : out_(std::cout.rdbuf(nowhere_.rdbuf())) {}
  ~Quiet() { std::cout.rdbuf(out_); }
  Quiet(const Quiet&) = delete;

 private:
  std::ostringstream nowhere_;
  std::streambuf* out_;
};

// The last line of an IGES file has a T in column 73. OpenCASCADE reads a truncated file as fewer faces, without an
// error.
bool is_whole_iges(const std::string& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (line.size() > 72) last = line;
  return last.size() > 72 && last[72] == 'T';
}

// Returns f() and turns failures of OpenCASCADE into Errors. Throws std::bad_alloc where memory is short.
template <class F>
auto guarded(const scene::LoadedScene& scene, const std::string& field, const std::string& path, F&& f) {
  try {
    return f();
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure& e) {
    scene.fail(field + ".path", fmt::format("'{}': OpenCASCADE fails with {} ({}); export it again, or simpler", path,
                                            e.DynamicType()->Name(), e.GetMessageString()));
  }
}

// Does in a process of its own what OpenCASCADE is to do here. Throws Error where that process does not come through.
void try_first(const scene::LoadedScene& scene, const std::string& field, const std::string& path,
               const std::function<void()>& work) {
  const double bytes = most_trial_bytes();
  std::string fault;
  try {
    fault = trial_fault(tried(work, kMostTrialS, bytes), "OpenCASCADE's reader", kMostTrialS, bytes);
  } catch (const std::system_error& e) {
    fault = fmt::format("was not read, as no process for it starts: {}; end others, or raise the limits of this one",
                        e.code().message());
  }
  scene.check(fault.empty(), field + ".path", "'{}' {}", path, fault);
}

// In a trial: does `work` and forgets why it fails, as it will fail again. Lack of memory ends the trial.
template <class F>
void attempt(F&& work) {
  try {
    work();
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure&) {
  } catch (const Error&) {
  }
}

// Unit of length of a file.
struct Unit {
  std::string name;    // empty: the file says none
  double taken = 1.0;  // by OpenCASCADE, where the file says none [mm]
};

Unit unit_of(XSControl_Reader& reader, bool step) {
  Unit out;
  if (step) {
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    static_cast<STEPControl_Reader&>(reader).FileUnits(lengths, angles, solid_angles);
    for (int i = 1; i <= lengths.Length() && out.name.empty(); ++i) out.name = lengths(i).ToCString();
    // Shapes that belong to no product have units, but are not asked
    const auto model = reader.WS()->Model();
    for (int i = 1; i <= model->NbEntities() && lengths.IsEmpty() && out.name.empty(); ++i)
      if (std::string(model->Value(i)->DynamicType()->Name()).ends_with("LengthUnit")) out.name = "a unit of length";
    return out;
  }
  const auto model = opencascade::handle<IGESData_IGESModel>::DownCast(reader.WS()->Model());
  if (model.IsNull()) return out;
  const IGESData_GlobalSection& global = model->GlobalSection();
  if (!global.UnitName().IsNull()) out.name = global.UnitName()->ToCString();
  // Where the number of the unit is missing, OpenCASCADE takes that of inches, 1.
  if (out.name.empty() && global.UnitFlag() > 1 && global.UnitFlag() != 3)
    out.name = IGESData_BasicEditor::UnitFlagName(global.UnitFlag());
  out.taken = global.UnitValue();
  return out;
}

// What is read of a file.
struct Content {
  TopoDS_Shape shape;
  std::string unit;                    // of length
  std::map<int, std::string> crossed;  // faces whose border crosses itself, and what is said of it
  CadNames names{};
};

// Brings a file that says no unit to millimetres. Throws Error where its unit is given twice or not at all.
void set_unit(const CadPlace& place, const proto::CadFace& cad, const Unit& unit, Content& out, double& factor) {
  const std::string field = place.field + ".unit_m";
  place.scene.check(!unit.name.empty() || cad.has_unit_m(), field,
                    "is missing, and '{}' says no unit of length; give 0.001 for millimetres, 0.0254 for inches",
                    place.path);
  place.scene.check(unit.name.empty() || !cad.has_unit_m(), field, "is {} m, and '{}' says its unit, {}; leave it out",
                    cad.unit_m(), place.path, unit.name);
  out.unit = unit.name;
  if (!cad.has_unit_m()) return;
  out.unit = fmt::format("{:g} m", cad.unit_m());
  factor = cad.unit_m() / (kMetresPerUnit * unit.taken);
  if (factor == 1.0 || out.shape.IsNull()) return;
  gp_Trsf scaled;
  scaled.SetScale(gp_Pnt(), factor);
  out.shape = BRepBuilderAPI_Transform(out.shape, scaled, Standard_True).Shape();
}

Content read(const CadPlace& place, const proto::CadFace& cad) {
  const std::string field = place.field + ".path";
  const std::filesystem::path file = place.scene.file_beside(field, place.path);
  std::string suffix = file.extension();
  for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool step = suffix == ".step" || suffix == ".stp", iges = suffix == ".igs" || suffix == ".iges";
  place.scene.check(step || iges, field,
                    "'{}' is neither STEP (.step, .stp) nor IGES (.igs, .iges); export one of them", place.path);
  place.scene.check(step || is_whole_iges(file), field,
                    "'{}' ends without the T line of an IGES file; is the copy whole?", place.path);
  std::unique_ptr<XSControl_Reader> reader;
  if (step)
    reader = std::make_unique<STEPControl_Reader>();
  else
    reader = std::make_unique<IGESControl_Reader>();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");  // after the first reader, which creates the table of settings
  place.scene.check(reader->ReadFile(file.c_str()) == IFSelect_RetDone, field,
                    "'{}' is no {} file that can be read; export it again", place.path, step ? "STEP" : "IGES");
  // OpenCASCADE follows broken references through null pointers, so such a file is refused here. Colours and styles of
  // lines are not read.
  int faults = 0;
  std::string first;
  Interface_CheckIterator checks = reader->WS()->ModelCheckList(Standard_False);
  for (checks.Start(); checks.More(); checks.Next()) {
    const int number = checks.Number();
    const bool style =
        number > 0 &&
        std::string(reader->WS()->Model()->Value(number)->DynamicType()->Name()).rfind("StepVisual_", 0) == 0;
    if (!style && checks.Value()->HasFailed() && faults++ == 0) first = checks.Value()->CFail(1);
  }
  place.scene.check(faults == 0, field, "'{}' is damaged: {} entries, the first with \"{}\"; export it again",
                    place.path, faults, first);
  reader->TransferRoots();
  Content out{reader->OneShape(), {}, {}};
  TopTools_IndexedMapOfShape faces;
  if (!out.shape.IsNull()) TopExp::MapShapes(out.shape, TopAbs_FACE, faces);
  double factor = 1.0;
  set_unit(place, cad, unit_of(*reader, step), out, factor);
  out.names = names_of(*reader, faces);
  out.crossed = crossed_faces(*reader, faces, factor);
  return out;
}

// 1 where the border of a face runs along an edge, -1 against it, 0 both ways.
int sense_in(const TopoDS_Shape& face, const TopoDS_Edge& edge) {
  int out = 0;
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next())
    if (it.Current().IsSame(edge)) out += it.Current().Orientation() == TopAbs_FORWARD ? 1 : -1;
  return std::clamp(out, -1, 1);
}

std::vector<NamedCadFaces> listed(const std::map<std::string, std::set<int> >& names) {
  std::vector<NamedCadFaces> out;
  for (const auto& [name, faces] : names) out.push_back({name, {faces.begin(), faces.end()}});
  return out;
}

}  // namespace

struct CadFile::Shape {
  std::string path, unit;
  TopTools_IndexedMapOfShape faces;  // numbered from 1, each once
  TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
  std::map<int, std::string> crossed;  // as Content has them
  std::vector<NamedCadFaces> bodies, layers;
  // by face, scale, width of filled holes, and whether it is turned over: some take long to approximate
  using Key = std::tuple<int, double, double, bool>;
  mutable std::map<Key, std::vector<CadSurface> > surfaces;
  mutable std::set<Key> tried;  // in a process of their own

  static Key key_of(const proto::CadFace& cad, int face, bool turned) {
    return {face, cad.has_scale() ? cad.scale() : 1.0, cad.fill_holes_m(), turned};
  }
};

std::shared_ptr<const CadFile::Shape> CadFile::shape_of(const scene::LoadedScene& scene, const std::string& field,
                                                        const proto::CadFace& cad) {
  const std::string& path = cad.path();
  auto out = std::make_shared<Shape>();
  out->path = path;
  guarded(scene, field, path, [&] {
    const Content content = read({scene, field, path}, cad);
    out->unit = content.unit, out->crossed = content.crossed;
    out->bodies = listed(content.names.bodies), out->layers = listed(content.names.layers);
    if (content.shape.IsNull()) return;
    TopExp::MapShapes(content.shape, TopAbs_FACE, out->faces);
    TopExp::MapShapesAndAncestors(content.shape, TopAbs_EDGE, TopAbs_FACE, out->faces_of_edge);
  });
  scene.check(out->faces.Extent() > 0, field + ".path",
              "'{}' has no face; export a surface, not curves, points or a mesh", path);
  return out;
}

void CadFile::ask_all(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) const {
  attempt([&] { edges(); });
  attempt([&] { box(); });
  std::vector<int> taken;
  attempt([&] { taken = chosen(scene, field, cad); });
  for (int k = 0; k < faces(); ++k) attempt([&] { kind(k); });
  if (static_cast<int>(taken.size()) > kMostFaces) return;
  for (const int face : taken)
    if (face < faces())
      attempt([&] {
        for (const CadSurface& s : converted(scene, field, cad, face, false))
          for (const CadLoop& loop : s.loops)
            for (const CadBorder& border : loop.borders) border.curve.at(0.0), border.curve.at(0.5);
      });
}

CadFile::CadFile(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) {
  const Quiet quiet;
  try_first(scene, field, cad.path(), [&] {
    attempt([&] { shape_ = shape_of(scene, field, cad); });
    if (shape_) ask_all(scene, field, cad);
  });
  shape_ = shape_of(scene, field, cad);
  const std::vector<int> taken = chosen(scene, field, cad);
  if (static_cast<int>(taken.size()) <= kMostFaces)
    for (const int face : taken) shape_->tried.insert(Shape::key_of(cad, face, false));
}

int CadFile::faces() const { return shape_->faces.Extent(); }
const std::vector<NamedCadFaces>& CadFile::bodies() const { return shape_->bodies; }
const std::vector<NamedCadFaces>& CadFile::layers() const { return shape_->layers; }

std::vector<int> CadFile::chosen(const scene::LoadedScene& scene, const std::string& field,
                                 const proto::CadFace& cad) const {
  if (cad.has_face()) return {cad.face()};
  for (int k = 0; k < cad.faces_size(); ++k)
    scene.check(cad.faces(k) < faces(), fmt::format("{}.faces[{}]", field, k),
                "is {}, but '{}' has {} faces, counted from 0", cad.faces(k), cad.path(), faces());
  if (cad.faces_size() > 0) return {cad.faces().begin(), cad.faces().end()};
  const bool body = !cad.body().empty();
  const std::string &name = body ? cad.body() : cad.layer(), own = field + (body ? ".body" : ".layer");
  if (name.empty()) {
    std::vector<int> all(faces());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  const char* kind = body ? "body" : "layer";
  std::vector<std::string> names;
  for (const NamedCadFaces& n : body ? bodies() : layers()) {
    if (n.name == name) return n.faces;
    names.push_back(n.name);
  }
  scene.check(!names.empty(), own,
              "is '{}', and no {} of '{}' with a face has a name; leave it out, or choose by faces", name, kind,
              shape_->path);
  scene.fail(own,
             fmt::format("is '{}', which is no {} of '{}'; {}", name, kind, shape_->path, did_you_mean(name, names)));
}

std::vector<CadSurface> CadFile::converted(const scene::LoadedScene& scene, const std::string& field,
                                           const proto::CadFace& cad, int face, bool turned) const {
  const CadPlace place{scene, field, shape_->path, face};
  const auto crossed = shape_->crossed.find(face);
  if (crossed != shape_->crossed.end()) place.check(false, "{}", crossed->second);
  return guarded(scene, field, shape_->path, [&] {
    const TopoDS_Shape& as_given = shape_->faces(face + 1);
    return convert_face(place, TopoDS::Face(turned ? as_given.Reversed() : as_given),
                        cad.has_scale() ? cad.scale() : 1.0, cad.fill_holes_m());
  });
}

std::vector<CadSurface> CadFile::surfaces(const scene::LoadedScene& scene, const std::string& field,
                                          const proto::CadFace& cad) const {
  const Quiet quiet;
  const int n = faces();
  scene.check(cad.face() < n, field + ".face", "is {}, but '{}' has {}, counted from 0", cad.face(), shape_->path,
              n == 1 ? "one face" : fmt::format("{} faces", n));
  const bool turned = cad.faces_size() > 0;
  const Shape::Key key = Shape::key_of(cad, cad.face(), turned);
  const auto known = shape_->surfaces.find(key);
  if (known != shape_->surfaces.end()) return known->second;
  const bool is_new = shape_->tried.insert(Shape::key_of(cad, cad.face(), false)).second;
  if (is_new)  // another shell of the scene has read the file
    try_first(scene, field, shape_->path, [&] { attempt([&] { converted(scene, field, cad, cad.face(), false); }); });
  return shape_->surfaces[key] = converted(scene, field, cad, cad.face(), turned);
}

std::vector<CadEdge> CadFile::edges() const {
  std::vector<CadEdge> out;
  for (int i = 1; i <= shape_->faces_of_edge.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(shape_->faces_of_edge.FindKey(i));
    if (BRep_Tool::Degenerated(edge)) continue;
    CadEdge e;
    for (const TopoDS_Shape& face : shape_->faces_of_edge.FindFromIndex(i)) {
      const int n = shape_->faces.FindIndex(face) - 1;
      if (std::find(e.faces.begin(), e.faces.end(), n) == e.faces.end())
        e.faces.push_back(n), e.senses.push_back(sense_in(shape_->faces(n + 1), edge));
    }
    // An edge at which a face meets itself
    if (e.faces.size() == 1 && BRep_Tool::IsClosed(edge, TopoDS::Face(shape_->faces(e.faces[0] + 1))))
      e.faces.push_back(e.faces[0]), e.senses.assign(2, 0);
    const BRepAdaptor_Curve curve(edge);
    const gp_Pnt middle = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()));
    e.length = kMetresPerUnit * GCPnts_AbscissaPoint::Length(curve);
    e.tolerance = kMetresPerUnit * BRep_Tool::Tolerance(edge);
    e.middle = kMetresPerUnit * Vec3(middle.X(), middle.Y(), middle.Z());
    const int stretches = curve.GetType() == GeomAbs_Line ? 1 : kStretches;
    for (int k = 0; k <= stretches; ++k) {
      const double share = static_cast<double>(k) / stretches;
      const gp_Pnt p = curve.Value((1.0 - share) * curve.FirstParameter() + share * curve.LastParameter());
      e.points.push_back(kMetresPerUnit * Vec3(p.X(), p.Y(), p.Z()));
    }
    out.push_back(std::move(e));
  }
  return out;
}

std::string CadFile::kind(int face) const {
  constexpr const char* kNames[] = {"plane",
                                    "cylinder",
                                    "cone",
                                    "sphere",
                                    "torus",
                                    "Bezier surface",
                                    "B-spline",
                                    "surface of revolution",
                                    "surface of extrusion",
                                    "offset surface"};
  const int type = BRepAdaptor_Surface(TopoDS::Face(shape_->faces(face + 1))).GetType();
  return type >= 0 && type < static_cast<int>(std::size(kNames)) ? kNames[type] : "surface";
}

const std::string& CadFile::unit() const { return shape_->unit; }

std::pair<Vec3, Vec3> CadFile::box() const {
  Bnd_Box box;
  for (int i = 1; i <= faces(); ++i) BRepBndLib::AddOptimal(shape_->faces(i), box, Standard_False);
  double x0, y0, z0, x1, y1, z1;
  box.Get(x0, y0, z0, x1, y1, z1);
  return {kMetresPerUnit * Vec3(x0, y0, z0), kMetresPerUnit * Vec3(x1, y1, z1)};
}

}  // namespace sunder::shell

#endif
