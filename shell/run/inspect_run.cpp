#include <cmath>

#include "coupler/core/command_line.h"
#include "shell/io/inspect.h"
#include "shell/io/inspect_mesh.h"
#include "shell/run/program.h"

namespace sunder::shell {

int inspect_program(int argc, char** argv) {
  std::string file, frame;
  MeshQuestion asked;
  double& element = asked.element;
  CLI::App app("Prints as JSON what a STEP, IGES or mesh file holds, and what of it would be refused.",
               "sunder-shell inspect");
  app.add_option("FILE", file, "The file")->required();
  app.add_option("--element", element, "Spacing of shells [m]; default: a fortieth of the file's size")->take_last();
  app.add_option("--unit", asked.unit, "Unit of a mesh [m], default: 1; or of a CAD file that says none")->take_last();
  app.add_option("--weld", asked.weld, "Points of a mesh no further apart become one [m]; default: 0")->take_last();
  app.add_option("--frame", frame, "Folder for a frame of the shells, as those of runs; default: none")->take_last();
  if (!read_arguments(app, argc, argv)) return 0;
  require(app.count("--element") == 0 || (element > 0.0 && std::isfinite(element)),
          "--element {}: must be positive and finite [m]; leave it out for a fortieth of the file's size", element);
  const bool mesh = is_mesh_file(file);
  require(mesh || app.count("--weld") == 0, "--weld: is for mesh files, and '{}' has its own topology; leave it out",
          file);
  asked.has_unit = app.count("--unit") > 0;
  require(asked.unit > 0.0 && std::isfinite(asked.unit), "--unit {}: must be positive and finite [m]", asked.unit);
  require(asked.weld >= 0.0 && std::isfinite(asked.weld), "--weld {}: must be zero or positive, and finite [m]",
          asked.weld);
  fmt::print("{}", mesh ? inspect_mesh_report(file, asked, frame)
                        : inspect_report(file, element, asked.has_unit ? asked.unit : 0.0, frame));
  return 0;
}

}  // namespace sunder::shell
