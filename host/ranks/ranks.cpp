// SPDX-License-Identifier: BSD-3-Clause
#include "host/ranks/ranks.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/system/process.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

Ranks* joined = nullptr;

/// A number of the environment; -1 where there is none.
int number_of(const char* name) {
  const char* const text = std::getenv(name);
  int number = -1;
  if (text != nullptr) {
    const char* const end = text + std::strlen(text);
    if (std::from_chars(text, end, number).ptr != end) return -1;
  }
  return number;
}

/// The library with MPI: beside the program where it was built, else where it was installed; empty
/// where there is none.
fs::path mpi_library() {
  std::error_code none;
  for (const fs::path& folder : {program_folder(), program_folder() / RA2D_MODULES_FROM_PROGRAM})
    if (fs::exists(folder / "libra2d_mpi.so", none)) return folder / "libra2d_mpi.so";
  return {};
}

}  // namespace

Launch launch() {
  struct Names {
    const char *rank, *size;
  };
  constexpr Names launchers[] = {
      {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},  // Open MPI
      {"PMI_RANK", "PMI_SIZE"},              // MPICH, Intel MPI, MVAPICH; srun --mpi=pmi2
      {"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}  // srun --mpi=pmix
  };
  for (const Names& names : launchers)
    if (const Launch found{number_of(names.rank), number_of(names.size)};
        found.rank >= 0 && found.rank < found.size)
      return found;
  return {};
}

Ranks* join_ranks() {
  const Launch mine = launch();
  if (mine.size == 1 || joined != nullptr) return joined;
  const fs::path file = mpi_library();
  if (file.empty())
    throw RequestError(fmt::format(
        "mpirun started {} processes, but this ra2d was built without MPI: each would do "
        "all of the work. Install MPI for building (Debian: libopenmpi-dev), run cmake and "
        "build again; or leave mpirun out and share the work with --shard I/N",
        mine.size));
  // what MPI loads itself looks for its symbols among all (Open MPI's components)
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (library == nullptr)
    throw FileError(
        fmt::format("cannot load MPI: {}. Install the MPI that ra2d was built with, or "
                    "build it again with the one that is here",
                    dlerror()));
  using Join = const char*(int size, Ranks** ranks);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): dlsym knows no types
  const auto join = reinterpret_cast<Join*>(dlsym(library, "ra2d_join_ranks"));
  if (join == nullptr)
    throw FileError(fmt::format("'{}' is not of this ra2d: install both anew", file.string()));
  if (const char* const fault = join(mine.size, &joined); fault != nullptr)
    throw FileError(fmt::format("cannot share work under mpirun: {}", fault));
  return joined;
}

Ranks* joined_ranks() { return joined; }

void require_one_process() {
  if (const int size = launch().size; size > 1)
    throw RequestError(fmt::format(
        "mpirun started {} processes, but they share nothing except the runs of a study "
        "(ra2d study STUDY.toml -o DIR): leave mpirun out for this. If each of them has work of "
        "its own, start ra2d in it by 'env -u OMPI_COMM_WORLD_SIZE -u PMI_SIZE -u PMIX_RANK'",
        size));
}

}  // namespace ra2d
