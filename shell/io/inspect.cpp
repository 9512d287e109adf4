#include "shell/io/inspect.h"

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "shell/io/build.h"
#include "shell/io/build_shell.h"
#include "shell/io/cad_parts.h"
#include "shell/io/element_fit.h"
#include "shell/io/inspect_frame.h"
#include "shell/io/near_parts.h"

namespace sunder::shell {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kElements = 40.0;       // along the diagonal of a file, by default
constexpr double kThicknessShare = 0.2;  // of an element: any thickness does

// A scene with one shell, of which the file is to become the patch.
scene::LoadedScene scene_of(const std::string& file, double element, double unit) {
  scene::LoadedScene scene;
  const std::filesystem::path path = std::filesystem::absolute(file);
  scene.path = path.parent_path() / "inspect.textproto";
  scene.message.set_end_time_s(1.0), scene.message.set_window_s(1e-3);
  proto::Material& material = *scene.message.add_materials();
  material.set_name("steel"), material.set_density(7800.0);
  material.set_youngs_modulus(2e11), material.set_poisson_ratio(0.3);
  proto::Shell& shell = *scene.message.add_shells();
  shell.set_name("part"), shell.set_material("steel"), shell.set_thickness_m(kThicknessShare * element);
  shell.mutable_cad()->set_path(path.filename()), shell.mutable_cad()->set_element_m(element);
  if (unit > 0.0) shell.mutable_cad()->set_unit_m(unit);
  return scene;
}

// What an Error is about, where its text does not say so: "element_m is 1e-6 m, and ...".
std::string subject_of(const std::string& field) {
  const std::string last = field.substr(field.rfind('.') + 1);
  if (last == "element_m") return "--element ";
  if (last == "unit_m") return "--unit ";
  return last.empty() || last == "path" || last == "cad" || last == "shells[0]" || last == "seams" ? "" : last + " ";
}

// The message of an Error without file and field, which belong to no scene of the user's.
std::string problem_of(const scene::LoadedScene& scene, const Error& e) {
  std::string text = e.what();
  for (const std::string& head : {scene.path + ": ", e.field + ": ", "'" + scene.message.shells(0).cad().path() + "': ",
                                  "'" + scene.message.shells(0).cad().path() + "' "})
    if (text.rfind(head, 0) == 0) text.erase(0, head.size());
  return subject_of(e.field) + text;
}

// The file, which has no scene yet: an Error is about the file itself.
const CadFile& read(const scene::LoadedScene& scene, CadFiles& files, const std::string& file) {
  try {
    return files.of(scene, "shells[0].cad", scene.message.shells(0).cad());
  } catch (const Error& e) {
    Error plain(e.status, "bad_input", file + ": " + problem_of(scene, e));
    plain.file = file;
    throw plain;
  }
}

Json face_of(const scene::LoadedScene& scene, const CadFile& file, CadFiles& files, int face, double element) {
  Json out = {{"face", face}, {"kind", file.kind(face)}};
  try {
    proto::Shell shell = scene.message.shells(0);
    shell.mutable_cad()->set_face(face);
    const std::vector<CadSurface> surfaces = file.surfaces(scene, "shells[0].cad", shell.cad());
    std::ptrdiff_t holes = 0, trimmed = 0;
    double area = 0.0, shortest = element, error = 0.0;
    ElementFit worst;
    Json widths = Json::array(), elements = Json::array();
    for (std::size_t k = 0; k < surfaces.size(); ++k) {
      const std::vector<CadLoop>& loops = surfaces[k].loops;
      const auto own = std::count_if(loops.begin(), loops.end(), [](const CadLoop& l) { return l.hole; });
      holes += own, trimmed += static_cast<std::ptrdiff_t>(loops.size()) > own;
      const ShellModel m = build_shell(scene, shell, "shells[0]", files, static_cast<int>(k));
      for (const double part : m.mass) area += part / (m.material.density * m.thickness);
      shortest = std::min(shortest, m.shortest_element);
      if (const ElementFit fit = element_fit(m, element); k == 0 || fit.step < worst.step) worst = fit;
      error = std::max(error, surfaces[k].error);
      widths.push_back(
          {m.patch.knots_u.end() - m.patch.knots_u.begin(), m.patch.knots_v.end() - m.patch.knots_v.begin()});
      elements.push_back({m.tables.spans_u, m.tables.spans_v});
    }
    out["degree"] = surfaces[0].patch.degree();
    out["parts"] = surfaces.size();
    out["width_m"] = widths[0];
    out["area_m2"] = surfaces[0].area;
    out["approximated_m"] = error;
    out["area_of_shells_m2"] = area;
    out["parts_trimmed"] = trimmed;
    out["holes"] = holes;
    out["elements"] = elements[0];
    out["shortest_element_m"] = shortest;
    out["stable_step_s"] = worst.step;
    out["unfit"] = worst.unfit;
    out["warning"] = worst.warning.empty() ? Json() : Json(worst.warning);
    out["shells"] = Json::array();  // in a scene of all faces that can be taken
    out["refused"] = nullptr;
  } catch (const Error& e) {
    out["refused"] = problem_of(scene, e);
  }
  return out;
}

Json named_of(const std::vector<NamedCadFaces>& list) {
  Json out = Json::array();
  for (const NamedCadFaces& n : list) out.push_back({{"name", n.name}, {"faces", n.faces}});
  return out;
}

Json points_json(const std::vector<Vec3>& points) {
  Json out = Json::array();
  for (const Vec3& p : points) out.push_back({p.x(), p.y(), p.z()});
  return out;
}

Json edges_of(const CadFile& file) {
  int free = 0, shared = 0, several = 0;
  double widest = 0.0;
  Json all = Json::array();
  for (const CadEdge& e : file.edges()) {
    free += e.faces.size() == 1, shared += e.faces.size() == 2, several += e.faces.size() > 2;
    widest = std::max(widest, e.tolerance);
    all.push_back({{"faces", e.faces},
                   {"length_m", e.length},
                   {"tolerance_m", e.tolerance},
                   {"points_m", points_json(e.points)}});
  }
  return {{"shared", shared},
          {"free", free},
          {"of_three_faces_or_more", several},
          {"widest_tolerance_m", widest},
          {"list", all}};
}

}  // namespace

std::string inspect_report(const std::string& file, double element, double unit, const std::string& frame) {
  const scene::LoadedScene first = scene_of(file, 1.0, unit);
  CadFiles files;
  const CadFile& cad = read(first, files, file);
  const auto [low, high] = cad.box();
  if (element <= 0.0) element = (high - low).norm() / kElements;
  scene::LoadedScene scene = scene_of(file, element, unit);
  Json faces = Json::array();
  std::vector<int> taken;
  for (int k = 0; k < cad.faces(); ++k) {
    if (cad.faces() > kMostFaces) {
      faces.push_back({{"face", k},
                       {"kind", cad.kind(k)},
                       {"refused", fmt::format("is not tried, as the file has {} faces, and at most {} become shells; "
                                               "choose some in a scene by `faces: [0, 1, 2]`",
                                               cad.faces(), kMostFaces)}});
      continue;
    }
    faces.push_back(face_of(scene, cad, files, k, element));
    if (faces.back()["refused"].is_null() && !faces.back()["unfit"].get<bool>()) taken.push_back(k);
  }
  for (const int k : taken)
    if (taken.size() < faces.size()) scene.message.mutable_shells(0)->mutable_cad()->add_faces(k);
  const Vec3 size = high - low;
  Json out = {{"file", file},
              {"unit", cad.unit()},
              {"unit_m", unit > 0.0 ? Json(unit) : Json()},
              {"low_m", {low.x(), low.y(), low.z()}},
              {"size_m", {size.x(), size.y(), size.z()}},
              {"element_m", element},
              {"thickness_m", scene.message.shells(0).thickness_m()},
              {"faces", faces},
              {"taken", taken},
              {"bodies", named_of(cad.bodies())},
              {"layers", named_of(cad.layers())},
              {"edges", edges_of(cad)}};
  out["seams"] = nullptr, out["seams_refused"] = nullptr, out["near"] = Json::array();
  if (!taken.empty()) try {
      const std::vector<ScenePart> parts = scene_parts(scene, files);
      for (const ScenePart& part : parts)
        out["faces"][part.message.cad().face()]["shells"].push_back(part.message.name());
      if (parts.size() > 1 || !frame.empty()) {
        const RunSetup setup = build(scene);
        if (!frame.empty()) write_frame_of(setup, frame);
        int smooth = 0, along_trims = 0;
        out["thickness_m"] = free_thickness(setup, scene.message.shells(0).thickness_m());
        for (const NearParts& near : near_parts(setup)) out["near"].push_back(near_warning(setup, near));
        for (const Seam& s : setup.stitches.seams) smooth += s.smooth, along_trims += s.trimmed();
        out["seams"] = {{"joined", setup.stitches.seams.size()}, {"smooth", smooth}, {"along_trims", along_trims}};
      }
    } catch (const Error& e) {
      out["seams_refused"] = problem_of(scene, e);
    }
  return out.dump(1) + "\n";
}

}  // namespace sunder::shell
