#include "shell/io/vtp.h"

#include <cstdint>
#include <cstdio>
#include <fstream>

#include "coupler/core/error.h"

namespace sunder::shell {
namespace {

struct Appended {
  std::string bytes;
  template <class T>
  std::size_t add(const std::vector<T>& values) {
    const std::size_t offset = bytes.size();
    const std::uint64_t size = values.size() * sizeof(T);
    bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes.append(reinterpret_cast<const char*>(values.data()), size);
    return offset;
  }
};

std::string data_array(Appended& data, const VtpArray& a) {
  const std::size_t offset =
      a.integer ? data.add(std::vector<std::int64_t>(a.values.begin(), a.values.end())) : data.add(a.values);
  std::string head = fmt::format("<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
                                 a.integer ? "Int64" : "Float64", a.name, a.components);
  for (std::size_t k = 0; k < a.component_names.size(); ++k)
    head += fmt::format(" ComponentName{}=\"{}\"", k, a.component_names[k]);
  head += fmt::format(" format=\"appended\" offset=\"{}\"", offset);
  if (a.unit.empty()) return head + "/>\n";
  return head + fmt::format(
                    "><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{}</InformationKey>"
                    "</DataArray>\n",
                    a.unit);
}

// The time, under the name that ParaView looks for, names of shells, letters as numbers, a zero after each, and areas.
std::string field_data(const VtpMesh& mesh) {
  std::string out = fmt::format(
      "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:.17g}"
      "</DataArray>\n",
      mesh.time);
  if (!mesh.shell_names.empty()) {
    out += fmt::format("<Array type=\"String\" Name=\"shell_name\" NumberOfTuples=\"{}\" format=\"ascii\">\n",
                       mesh.shell_names.size());
    for (const std::string& name : mesh.shell_names) {
      for (const char c : name) out += fmt::format("{} ", static_cast<int>(static_cast<unsigned char>(c)));
      out += "0\n";
    }
    out += "</Array>\n";
  }
  if (!mesh.shell_areas.empty()) {
    out += fmt::format("<DataArray type=\"Float64\" Name=\"shell_area_m2\" NumberOfTuples=\"{}\" format=\"ascii\">",
                       mesh.shell_areas.size());
    for (const double area : mesh.shell_areas) out += fmt::format("{:.17g} ", area);
    out += "</DataArray>\n";
  }
  return out + "</FieldData>\n";
}

std::string cells(Appended& data, const char* tag, const std::vector<std::vector<int>>& cells) {
  std::vector<std::int64_t> connectivity, offsets;
  for (const auto& c : cells) {
    connectivity.insert(connectivity.end(), c.begin(), c.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  const std::size_t first = data.add(connectivity), second = data.add(offsets);
  return fmt::format(
      "<{0}>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"appended\" offset=\"{1}\"/>\n"
      "<DataArray type=\"Int64\" Name=\"offsets\" format=\"appended\" offset=\"{2}\"/>\n</{0}>\n",
      tag, first, second);
}

}  // namespace

void write_vtp(const std::string& path, const VtpMesh& mesh) {
  Appended data;
  std::string head = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<PolyData>\n{}<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"{}\">\n",
      field_data(mesh), mesh.points.size(), mesh.verts.size(), mesh.lines.size(), mesh.polygons.size());
  VtpArray points{"Points", 3, {}};
  for (const Vec3& p : mesh.points) points.values.insert(points.values.end(), {p.x(), p.y(), p.z()});
  head += "<PointData>\n";
  for (const auto& a : mesh.point_data) head += data_array(data, a);
  head += "</PointData>\n<CellData>\n";
  for (const auto& a : mesh.cell_data) head += data_array(data, a);
  head += "</CellData>\n<Points>\n" + data_array(data, points) + "</Points>\n";
  if (!mesh.verts.empty()) {
    std::vector<std::vector<int>> single;
    for (const int v : mesh.verts) single.push_back({v});
    head += cells(data, "Verts", single);
  }
  head += cells(data, "Lines", mesh.lines) + cells(data, "Polys", mesh.polygons);
  head += "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  write_atomically(path, head + data.bytes + "\n</AppendedData>\n</VTKFile>\n");
}

void write_atomically(const std::string& path, const std::string& text) {
  const std::string part = path + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    out << text;
    out.flush();
    if (!out.good()) {
      std::remove(part.c_str());
      throw Error(Exit::kBadInput, "bad_output",
                  fmt::format("{}: cannot be written; is there room and permission?", path));
    }
  }
  if (std::rename(part.c_str(), path.c_str()) == 0) return;
  std::remove(part.c_str());
  throw Error(Exit::kBadInput, "bad_output", fmt::format("{}: cannot be replaced; is it a folder?", path));
}

}  // namespace sunder::shell
