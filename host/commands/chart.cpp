// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "host/chart/files.hpp"
#include "host/chart/stability_chart.hpp"
#include "host/commands/commands.hpp"
#include "host/errors.hpp"
#include "host/run/batch.hpp"
#include "paper_scene.hpp"

namespace ra2d {

int chart_stability_command(const CommonOptions& common, const std::string& prefix, bool plot) {
  const std::filesystem::path target(prefix);
  if (!target.has_filename() || std::filesystem::is_directory(target))
    throw RequestError(
        fmt::format("-o {}: a folder: expected the beginning of the files' names, like {}stability",
                    prefix, target.has_filename() ? prefix + "/" : prefix));
  if (target.has_parent_path() && !std::filesystem::is_directory(target.parent_path()))
    throw FileError(fmt::format("cannot write '{}.csv': there is no folder '{}'", prefix,
                                target.parent_path().string()));
  const Scene scene = common.scene.empty()
                          ? parse_scene(paper_scene, "dang2012.toml", common.overrides)
                          : read_scene(common.scene, common.overrides);
  if (!(scene.step > 0))
    throw RequestError(
        fmt::format("{}: time.step: missing: the chart places the scene's modes by its step, which "
                    "time.scheme = \"adaptive\" does without (add one, or --set time.step=1e-8)",
                    scene.file.string()));
  const Model model = make_model(scene);
  const std::string modes = modes_csv(model);
  const Backend backend(common.threads);
  const std::vector<Limit> limits = make_limits();
  fmt::print("{}", describe(limits));
  std::fflush(stdout);

  const std::string table = prefix + ".csv", regions = prefix + "-regions.csv",
                    eigenvalues = prefix + "-modes.csv", picture = prefix + ".png";
  write_text(table, limits_csv(limits));
  write_text(regions, regions_csv());
  write_text(eigenvalues, modes);
  const std::string texts = fmt::format("{}, {} and {}", table, regions, eigenvalues);
  if (plot) try {
      draw("plot_stability.py",
           {table, regions, eigenvalues, picture,
            fmt::format("{}, step {:g} s",
                        scene.name.empty() ? scene.file.filename().string() : scene.name,
                        scene.step)});
    } catch (const FileError& fault) {
      throw FileError(
          fmt::format("the picture {} was not made: {}. The table is in {}; --no-plot asks for no "
                      "picture",
                      picture, fault.what(), texts));
    }
  if (!common.quiet)
    fmt::print("\nwritten: {}{}\n", texts, plot ? "; the picture: " + picture : "");
  return done;
}

}  // namespace ra2d
