// SPDX-License-Identifier: BSD-3-Clause
// Profiles in X3P. Run by run.sh. What begins with PK is taken as an archive; no fuzzer would get
// past its sums. Anything else is main.xml, a zero, a byte that tells how long the mask is, the
// data and the mask. It is packed as an archive whose sums are right: MD5 in main.xml stands for
// that of the data.
#include <zip.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "host/surface/md5.hpp"
#include "host/surface/profile_x3p.hpp"
#include "tests/fuzz/fuzz_reader.hpp"

namespace {

std::string md5_of(const std::string& bytes) {
  ra2d::Md5 md5;
  md5.add(bytes.data(), bytes.size());
  return md5.hex();
}

/// An archive in memory.
std::vector<std::uint8_t> pack(const std::vector<std::pair<std::string, std::string>>& files) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* memory = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_source_keep(memory);
  zip_t* archive = zip_open_from_source(memory, ZIP_TRUNCATE, &error);
  if (archive == nullptr) std::abort();
  for (const auto& [name, text] : files) {
    const zip_int64_t index =
        zip_file_add(archive, name.c_str(), zip_source_buffer(archive, text.data(), text.size(), 0),
                     ZIP_FL_ENC_UTF_8);
    if (index < 0) std::abort();
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
  }
  if (zip_close(archive) != 0) std::abort();
  zip_source_open(memory);
  zip_stat_t stat;
  zip_stat_init(&stat);
  zip_source_stat(memory, &stat);
  std::vector<std::uint8_t> bytes(stat.size);
  zip_source_read(memory, bytes.data(), bytes.size());
  zip_source_close(memory);
  zip_source_free(memory);
  return bytes;
}

std::vector<std::uint8_t> archive_of(std::string_view input) {
  std::string main(input.substr(0, input.find('\0')));
  input.remove_prefix(std::min(main.size() + 1, input.size()));
  const std::size_t mask_bytes = input.empty() ? 0 : static_cast<unsigned char>(input[0]);
  if (!input.empty()) input.remove_prefix(1);
  const std::size_t data_bytes = input.size() - std::min(mask_bytes, input.size());
  const std::string data(input.substr(0, data_bytes)), mask(input.substr(data_bytes));
  if (const std::size_t at = main.find(">MD5<"); at != main.npos)
    main.replace(at + 1, 3, md5_of(data));
  return pack({{"main.xml", main},
               {"md5checksum.hex", md5_of(main)},
               {"bindata/data.bin", data},
               {"bindata/valid.bin", mask}});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ra2d;
  std::vector<std::uint8_t> archive(bytes, bytes + size);
  if (size < 2 || bytes[0] != 'P' || bytes[1] != 'K')
    archive = archive_of({reinterpret_cast<const char*>(bytes), size});
  const auto file = fuzz::file_of(archive.data(), archive.size());
  ProfileQuery row, column;
  row.row = 2;
  column.column = 2;
  for (const ProfileQuery& query : {ProfileQuery{}, row, column})
    fuzz::expect_profile_or_error(read_profile_x3p, file, query);
  return 0;
}
