// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/sealed_hdf5.hpp"

#if __has_include(<H5FDdevelop.h>)
#include <H5FDdevelop.h>  // where HDF5 1.14 has its drivers
#endif

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "host/base/text.hpp"
#include "host/store/seal.hpp"
#include "host/system/child_answer.hpp"
#include "host/system/input_file.hpp"

// HDF5 reads files through drivers: tables of functions that it calls. This one reads SealedBytes.
// Its functions are called from C, so none of them throws.
namespace ra2d {
namespace {

struct SealedFile {
  explicit SealedFile(const std::filesystem::path& path) : input{path}, bytes{input.descriptor()} {}
  InputFile input;
  SealedBytes bytes;
};

/// An open file as HDF5 knows it. HDF5 fills in the base.
struct DriverFile : H5FD_t {
  std::shared_ptr<SealedBytes> bytes;
  haddr_t end_of_allocation = 0;
};

/// Carries the bytes from open_sealed() to the driver. HDF5 copies it byte by byte.
struct DriverRequest {
  std::shared_ptr<SealedBytes>* bytes;
};

DriverFile& driver_file(H5FD_t* file) { return *static_cast<DriverFile*>(file); }
const DriverFile& driver_file(const H5FD_t* file) { return *static_cast<const DriverFile*>(file); }

void report(const char* reason) {
  H5Epush2(H5E_DEFAULT, __FILE__, "ra2d", __LINE__, H5E_ERR_CLS, H5E_IO, H5E_READERROR, "%s",
           reason);
}

H5FD_t* open_driver(const char*, unsigned flags, hid_t access, haddr_t) {
  const auto* const request = static_cast<const DriverRequest*>(H5Pget_driver_info(access));
  if (request == nullptr || *request->bytes == nullptr || (flags & H5F_ACC_RDWR) != 0)
    return nullptr;
  auto* const opened = new (std::nothrow) DriverFile{};
  if (opened != nullptr) opened->bytes = std::move(*request->bytes);
  return opened;
}

herr_t close_driver(H5FD_t* file) {
  delete &driver_file(file);
  return 0;
}

herr_t query_driver(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE;
  return 0;
}

haddr_t end_of_allocation(const H5FD_t* file, H5FD_mem_t) {
  return driver_file(file).end_of_allocation;
}

herr_t set_end_of_allocation(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  driver_file(file).end_of_allocation = end;
  return 0;
}

haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) { return driver_file(file).bytes->size(); }

template <class Number>
Number number_at(SealedBytes& bytes, std::uint64_t at) {
  char read[sizeof(Number)];
  bytes.read(at, read, sizeof read);
  Number number;
  std::memcpy(&number, read, sizeof read);
  return number;
}

/// Whether the objects of the global heap at `heap` (a collection of texts; HDF5 File Format
/// Specification, III.E) follow one another up to its end. HDF5 copies as many bytes as an object
/// says that it has, and looks at neither end of that.
bool is_whole_heap(SealedBytes& bytes, std::uint64_t heap) {
  constexpr std::uint64_t header = 16, unit = 8;  // bytes; of the heap and of each object
  if (header > bytes.size() - heap) return false;
  std::uint64_t left = number_at<std::uint64_t>(bytes, heap + 8);
  if (left < header || left > bytes.size() - heap) return false;
  std::uint64_t at = heap + header;
  for (left -= header; left >= header;) {  // fewer bytes are free room
    const auto size = number_at<std::uint64_t>(bytes, at + 8);
    if (number_at<std::uint16_t>(bytes, at) == 0)
      return size == left;  // the free room, with header
    if (size > left - header) return false;
    const std::uint64_t whole = header + (size + unit - 1) / unit * unit;
    if (whole > left) return false;
    at += whole;
    left -= whole;
  }
  return true;
}

/// Zeros stand behind the end, as in HDF5's own drivers.
herr_t read_driver(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, void* to) try {
  SealedBytes& bytes = *driver_file(file).bytes;
  const std::uint64_t left = bytes.size() - std::min<std::uint64_t>(at, bytes.size());
  const auto there = static_cast<std::size_t>(std::min<std::uint64_t>(count, left));
  if (there > 0) bytes.read(at, static_cast<char*>(to), there);
  std::memset(static_cast<char*>(to) + there, 0, count - there);
  constexpr char heap[] = {'G', 'C', 'O', 'L', 1, 0, 0, 0};  // its signature and version
  if (there >= sizeof heap && std::memcmp(to, heap, sizeof heap) == 0 &&
      !is_whole_heap(bytes, at)) {
    report("the lengths of its texts do not fit their global heap");
    return -1;
  }
  return 0;
} catch (const std::exception& fault) {
  report(fault.what());
  return -1;
}

herr_t refuse_to_write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) {
  report("the file is open for reading alone");
  return -1;
}

hid_t sealed_driver() {
  static const hid_t driver = [] {
    static H5FD_class_t functions{};
#ifdef H5FD_CLASS_VERSION
    functions.version = H5FD_CLASS_VERSION;
    functions.value = static_cast<H5FD_class_value_t>(600);  // HDF5 leaves those from 512 on free
#endif
    functions.name = "ra2d_sealed";
    functions.maxaddr = HADDR_MAX;
    functions.fc_degree = H5F_CLOSE_WEAK;
    functions.fapl_size = sizeof(DriverRequest);
    functions.open = open_driver;
    functions.close = close_driver;
    functions.query = query_driver;
    functions.get_eoa = end_of_allocation;
    functions.set_eoa = set_end_of_allocation;
    functions.get_eof = end_of_file;
    functions.read = read_driver;
    functions.write = refuse_to_write;
    return h5::check(H5FDregister(&functions));
  }();
  return driver;
}

}  // namespace

h5::CrashWatch::CrashWatch(const std::filesystem::path& file)
    : message_(
          fmt::format("ra2d: cannot read '{0}': HDF5 crashed on it, so it is damaged or forged, "
                      "although its seal fits. 'ra2d check {0}' has details\n",
                      printable(file.string()))) {}

h5::File open_sealed(const std::filesystem::path& path) {
  const auto file = std::make_shared<SealedFile>(path);
  return open_sealed(path, {file, &file->bytes});
}

h5::File open_sealed(const std::filesystem::path& path, std::shared_ptr<SealedBytes> bytes) {
  const h5::Properties access{h5::check(H5Pcreate(H5P_FILE_ACCESS))};
  const DriverRequest request{&bytes};
  h5::check(H5Pset_driver(access, sealed_driver(), &request));
  return h5::File{h5::check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access))};
}

bool is_damaged_with(const std::filesystem::path& file, const char* attribute) {
  const InputFile input(file);
  if (!looks_like_hdf5(file) || has_fitting_seal(input.descriptor())) return false;
  constexpr double memory = 256e6, seconds = 5;  // bytes, s
  const ChildAnswer answer = ask_in_child(
      [&] {
        const h5::Properties how = h5::file_access();
        const h5::File opened{H5Fopen(file.c_str(), H5F_ACC_RDONLY, how)};
        return std::string(opened.is_open() && H5Aexists(opened, attribute) <= 0 ? "foreign" : "");
      },
      memory, seconds);
  return answer.text != "foreign";
}

}  // namespace ra2d
