// The only file that uses OpenCASCADE.
#include "shell/io/cad_file.h"

#ifndef SUNDER_CAD

namespace sunder::shell {

Patch read_cad(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace&) {
  scene.fail(field, "this build has no OpenCASCADE, which reads STEP and IGES; run `coupler/sunder build --cad`");
}

}  // namespace sunder::shell

#else

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include <BRepAdaptor_Curve.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <IGESControl_Reader.hxx>
#include <Interface_Check.hxx>
#include <Interface_CheckIterator.hxx>
#include <Interface_Static.hxx>
#include <Precision.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <XSControl_WorkSession.hxx>

namespace sunder::shell {
namespace {

using Spline = opencascade::handle<Geom_BSplineSurface>;

constexpr int kHighestDegree = 3;        // of a patch
constexpr double kMetresPerUnit = 1e-3;  // OpenCASCADE's tolerances fit millimetres, so it converts to them
// Shares of the face's size. Files have tolerances of about a micrometre; no feature of a shell is that fine.
constexpr double kTrimTolerance = 1e-5;    // a border may leave the sides of the parameter rectangle by this
constexpr double kSmoothTolerance = 1e-9;  // the surface may move by this where a needless knot is removed
constexpr double kSnapTolerance = 1e-7;    // share of the parameter range: a border this near a knot is moved to it
constexpr int kSamplesPerEdge = 33;

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

/// The place that messages refer to.
struct Place {
  const scene::LoadedScene& scene;
  std::string field, path;  // field of the message; path of the file
  int face = 0;

  template <class... Args>
  void check(bool good, fmt::format_string<Args...> format, Args&&... args) const {
    if (!good)
      scene.fail(field + ".path",
                 fmt::format("'{}': face {} ", path, face) + fmt::format(format, std::forward<Args>(args)...));
  }
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

TopoDS_Shape read(const Place& place) {
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
  // OpenCASCADE follows broken references through null pointers, so such a file is refused here.
  int faults = 0;
  std::string first;
  Interface_CheckIterator checks = reader->WS()->ModelCheckList(Standard_False);
  for (checks.Start(); checks.More(); checks.Next())
    if (checks.Value()->HasFailed() && faults++ == 0) first = checks.Value()->CFail(1);
  place.scene.check(faults == 0, field, "'{}' is damaged: {} entries, the first with \"{}\"; export it again",
                    place.path, faults, first);
  reader->TransferRoots();
  return reader->OneShape();
}

// Returns the mean of a face's corners [m], for messages that list faces.
Vec3 mean_corner(const TopoDS_Face& face) {
  Vec3 sum = Vec3::Zero();
  int n = 0;
  for (TopExp_Explorer it(face, TopAbs_VERTEX); it.More(); it.Next(), ++n) {
    const gp_Pnt p = BRep_Tool::Pnt(TopoDS::Vertex(it.Current()));
    sum += kMetresPerUnit * Vec3(p.X(), p.Y(), p.Z());
  }
  return sum / std::max(1, n);
}

TopoDS_Face choose(const Place& place, const proto::CadFace& cad, const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape faces;  // numbered from 1, each face once
  if (!shape.IsNull()) TopExp::MapShapes(shape, TopAbs_FACE, faces);
  const int n = faces.Extent();
  place.scene.check(n > 0, place.field + ".path", "'{}' has no face; export a surface, not curves, points or a mesh",
                    place.path);
  if (!cad.has_face() && n > 1) {
    std::string all;
    for (int i = 0; i < n; ++i) {
      const Vec3 at = mean_corner(TopoDS::Face(faces(i + 1)));
      all += fmt::format("{}{} at ({:.4g}, {:.4g}, {:.4g}) m", i ? ", " : "", i, at.x(), at.y(), at.z());
    }
    place.scene.fail(place.field, fmt::format("'{}' has {} faces; choose one with `face`: {}", place.path, n, all));
  }
  place.scene.check(cad.face() < n, place.field + ".face", "is {}, but '{}' has {}, counted from 0", cad.face(),
                    place.path, n == 1 ? "one face" : fmt::format("{} faces", n));
  return TopoDS::Face(faces(cad.face() + 1));
}

struct Rectangle {
  std::array<double, 2> u, v;
};

// Moves a value to a bound or knot that it nearly equals. Otherwise spans become slivers.
double snapped(double value, double range, const std::vector<double>& marks) {
  for (const double mark : marks)
    if (std::abs(value - mark) <= kSnapTolerance * range) return mark;
  return value;
}

void snap(const opencascade::handle<Geom_Surface>& surface, Rectangle& r) {
  std::vector<double> u(2), v(2);
  surface->Bounds(u[0], u[1], v[0], v[1]);
  if (const Spline spline = Spline::DownCast(surface); !spline.IsNull()) {
    for (const double knot : spline->UKnots()) u.push_back(knot);
    for (const double knot : spline->VKnots()) v.push_back(knot);
  }
  const double range_u = r.u[1] - r.u[0], range_v = r.v[1] - r.v[0];
  for (double& value : r.u) value = snapped(value, range_u, u);
  for (double& value : r.v) value = snapped(value, range_v, v);
}

// Throws Error where the face has holes, with the place and width of the first one.
void refuse_holes(const Place& place, const TopoDS_Face& face) {
  const TopoDS_Wire outer = BRepTools::OuterWire(face);
  int holes = 0;
  Eigen::AlignedBox3d box;  // [mm]
  for (TopExp_Explorer wire(face, TopAbs_WIRE); wire.More(); wire.Next()) {
    if (wire.Current().IsSame(outer) || holes++ > 0) continue;
    for (TopExp_Explorer it(wire.Current(), TopAbs_EDGE); it.More(); it.Next()) {
      const BRepAdaptor_Curve curve(TopoDS::Edge(it.Current()));
      for (int i = 0; i < kSamplesPerEdge; ++i) {
        const double share = static_cast<double>(i) / (kSamplesPerEdge - 1);
        const gp_Pnt p = curve.Value(curve.FirstParameter() + share * (curve.LastParameter() - curve.FirstParameter()));
        box.extend(Vec3(p.X(), p.Y(), p.Z()));
      }
    }
  }
  if (holes == 0) return;
  const Vec3 centre = kMetresPerUnit * box.center();
  place.check(false,
              "has {}, the first one at ({:.4g}, {:.4g}, {:.4g}) m, {:.3g} m wide; a patch has none: take them out in "
              "the CAD program, and give the shell a closed cut for each, `cuts {{ circle {{ center {{ u v }} radius_m "
              "}} }}` or a closed curve, in metres along u and v from the patch's first corner",
              holes == 1 ? "a hole" : fmt::format("{} holes", holes), centre.x(), centre.y(), centre.z(),
              kMetresPerUnit * box.sizes().maxCoeff());
}

// Returns the parameter rectangle of a face. Throws Error where the face does not fill one.
Rectangle parameters(const Place& place, const TopoDS_Face& face, const opencascade::handle<Geom_Surface>& surface) {
  Rectangle r;
  refuse_holes(place, face);
  std::vector<gp_Pnt2d> border;
  for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next()) {
    double from = 0.0, to = 0.0;
    const opencascade::handle<Geom2d_Curve> curve =
        BRep_Tool::CurveOnSurface(TopoDS::Edge(it.Current()), face, from, to);
    place.check(!curve.IsNull(), "has an edge without a curve in its parameters; export it again");
    for (int i = 0; i < kSamplesPerEdge; ++i)
      border.push_back(curve->Value(from + (to - from) * i / (kSamplesPerEdge - 1)));
  }
  if (border.empty()) {
    surface->Bounds(r.u[0], r.u[1], r.v[0], r.v[1]);
    for (const double bound : {r.u[0], r.u[1], r.v[0], r.v[1]})
      place.check(!Precision::IsInfinite(bound), "has no end; give it borders in the CAD program");
    return r;
  }
  r.u = {border[0].X(), border[0].X()}, r.v = {border[0].Y(), border[0].Y()};
  for (const gp_Pnt2d& p : border) {
    r.u = {std::min(r.u[0], p.X()), std::max(r.u[1], p.X())};
    r.v = {std::min(r.v[0], p.Y()), std::max(r.v[1], p.Y())};
  }
  snap(surface, r);
  Eigen::AlignedBox3d box;
  const auto at = [&](double u, double v) {
    const gp_Pnt p = surface->Value(u, v);
    return Vec3(p.X(), p.Y(), p.Z());
  };
  for (const gp_Pnt2d& p : border) box.extend(at(p.X(), p.Y()));
  double most = 0.0;
  Vec3 where = Vec3::Zero();
  for (const gp_Pnt2d& p : border) {
    const Vec3 x = at(p.X(), p.Y());
    const double off = std::min({(x - at(r.u[0], p.Y())).norm(), (x - at(r.u[1], p.Y())).norm(),
                                 (x - at(p.X(), r.v[0])).norm(), (x - at(p.X(), r.v[1])).norm()});
    if (off > most) most = off, where = kMetresPerUnit * x;
  }
  const double size = box.diagonal().norm();
  place.check(most <= kTrimTolerance * size,
              "is trimmed: its border leaves the parameter lines by up to {:.2g} m, {:.2g} of its size, at ({:.4g}, "
              "{:.4g}, {:.4g}) m, and {:.0e} of its size is allowed; a patch has four sides along them: rebuild the "
              "surface so in the CAD program",
              kMetresPerUnit * most, most / size, where.x(), where.y(), where.z(), kTrimTolerance);
  return r;
}

// Prepares the u direction: open knots, two free ends, no more knots than a smooth surface needs.
void prepare_u(const Place& place, const Spline& s, double size, const char* direction) {
  if (s->IsUPeriodic()) s->SetUNotPeriodic();
  const int degree = s->UDegree(), last = s->NbUKnots();
  if (s->UMultiplicity(1) <= degree || s->UMultiplicity(last) <= degree) {  // the knot vector is not open
    double u0, u1, v0, v1;
    s->Bounds(u0, u1, v0, v1);
    s->Segment(u0, u1, v0, v1);
  }
  bool closed = true;
  for (int j = 1; j <= s->NbVPoles(); ++j)
    closed = closed && s->Pole(1, j).Distance(s->Pole(s->NbUPoles(), j)) <= kTrimTolerance * size;
  place.check(!closed, "closes on itself along {}, and a patch would be slit there; split it in the CAD program",
              direction);
  for (int k = s->NbUKnots() - 1; k > 1; --k) {
    const double share = (s->UKnot(k) - s->UKnot(1)) / (s->UKnot(s->NbUKnots()) - s->UKnot(1));
    place.check(s->UMultiplicity(k) < degree || s->RemoveUKnot(k, degree - 1, kSmoothTolerance * size),
                "has a crease, or an arc of 150 degrees or more in pieces, across {} at {:.4g} of its range (a knot "
                "{} times at degree {}); bending needs a smooth surface: split the face there in the CAD program",
                direction, share, s->UMultiplicity(k), degree);
  }
}

Spline to_spline(const Place& place, const TopoDS_Face& face) {
  const opencascade::handle<Geom_Surface> surface = BRep_Tool::Surface(face);
  place.check(!surface.IsNull(), "has no surface, a mesh perhaps; export the surface itself");
  const Rectangle r = parameters(place, face, surface);
  const Spline s =
      GeomConvert::SurfaceToBSplineSurface(new Geom_RectangularTrimmedSurface(surface, r.u[0], r.u[1], r.v[0], r.v[1]));
  const int degree = std::max({2, s->UDegree(), s->VDegree()});
  place.check(degree <= kHighestDegree,
              "has degree {} along u and {} along v; at most {} can be used: rebuild the surface as degree {} in the "
              "CAD program",
              s->UDegree(), s->VDegree(), kHighestDegree, kHighestDegree);
  s->IncreaseDegree(degree, degree);
  Eigen::AlignedBox3d box;
  for (int j = 1; j <= s->NbVPoles(); ++j)
    for (int i = 1; i <= s->NbUPoles(); ++i) box.extend(Vec3(s->Pole(i, j).X(), s->Pole(i, j).Y(), s->Pole(i, j).Z()));
  for (const char* direction : {"u", "v"}) {
    prepare_u(place, s, box.diagonal().norm(), direction);
    s->ExchangeUV();  // the second exchange restores the order
  }
  if (face.Orientation() == TopAbs_REVERSED) s->ExchangeUV();  // u cross v is the face's normal
  return s;
}

Patch to_patch(const Spline& s, double scale, const std::string& field) {
  const int degree = s->UDegree();  // the same for v
  const auto knots = [degree](const TColStd_Array1OfReal& k, const char* name) {
    return KnotVector({k.begin(), k.end()}, degree, name);
  };
  Patch patch{knots(s->UKnotSequence(), "knots along u"), knots(s->VKnotSequence(), "knots along v"), {}, {}};
  for (int j = 1; j <= s->NbVPoles(); ++j)
    for (int i = 1; i <= s->NbUPoles(); ++i) {
      const gp_Pnt p = s->Pole(i, j);
      patch.control_points.push_back(scale * Vec3(p.X(), p.Y(), p.Z()));
      patch.weights.push_back(s->Weight(i, j));
    }
  validate(patch, field);
  return patch;
}

}  // namespace

Patch read_cad(const scene::LoadedScene& scene, const std::string& field, const proto::CadFace& cad) {
  const Quiet quiet;
  const Place place{scene, field, cad.path(), cad.face()};
  try {
    const Spline s = to_spline(place, choose(place, cad, read(place)));
    return to_patch(s, kMetresPerUnit * (cad.has_scale() ? cad.scale() : 1.0), place.path);
  } catch (const Standard_Failure& e) {
    scene.fail(field + ".path", fmt::format("'{}': OpenCASCADE fails with {} ({}); export it again, or simpler",
                                            cad.path(), e.DynamicType()->Name(), e.GetMessageString()));
  }
}

}  // namespace sunder::shell

#endif
