# SPDX-License-Identifier: BSD-3-Clause
import pathlib

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator
from spack_repo.builtin.build_systems.cuda import CudaPackage

from spack.package import *


class Ra2d(CMakePackage, CudaPackage):
    """Friction noise of rough surfaces: two beams slide past each other, their asperities
    collide, each collision rings the beams' modes."""

    # the clone that this recipe stands in
    git = pathlib.Path(__file__).resolve().parents[4].as_uri()

    license("BSD-3-Clause")

    version("main", branch="main")

    variant("openmp", default=True, description="Several threads")
    variant("mpi", default=False, description="Studies under mpirun")
    variant("python", default=True, description="Pictures, sound, pages and the Python package")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")

    depends_on("kokkos@5.0:5 cxxstd=20")
    depends_on("kokkos+openmp", when="+openmp")
    for arch in CudaPackage.cuda_arch_values:
        depends_on(f"kokkos+cuda cuda_arch={arch}", when=f"+cuda cuda_arch={arch}")
    depends_on("cli11@2.1:")
    depends_on("eigen@3.3:")
    depends_on("fftw@3.3: precision=double")
    depends_on("fmt@9:")
    depends_on("hdf5@1.10.3: +hl ~mpi")
    depends_on("libzip")
    depends_on("nlohmann-json@3.11:")
    depends_on("openssl")
    depends_on("pugixml")
    depends_on("random123")
    depends_on("tomlplusplus")
    depends_on("xxhash@0.8:")
    depends_on("mpi", when="+mpi")
    with when("+python"):
        depends_on("python@3.11:", type="run")
        for module in ("h5py", "jinja2", "matplotlib", "numpy", "pandas", "scipy",
                       "soundfile", "xarray", "xxhash"):
            depends_on(f"py-{module}", type="run")

    generator("ninja")

    def cmake_args(self):
        spec = self.spec
        backend = "CUDA" if "+cuda" in spec else "OpenMP" if "+openmp" in spec else "Serial"
        return [
            self.define("RA2D_BACKEND", backend),
            self.define("RA2D_TESTS", False),
            self.define("RA2D_BENCH", False),
            self.define("Kokkos_ROOT", spec["kokkos"].prefix),
            self.define("CMAKE_DISABLE_FIND_PACKAGE_MPI", "~mpi" in spec),
        ]

    def setup_run_environment(self, env):
        if "+python" in self.spec:
            env.prepend_path("PYTHONPATH", self.prefix.share.ra2d)
