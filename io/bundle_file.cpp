#include "io/bundle_file.h"

#include "io/described_file.h"

namespace plumb::io {
namespace {

constexpr const char* no_kind = "";

}  // namespace

void write_bundle(const std::string& path, const Bundle& bundle) {
    DescribedFile file;
    file.kind = no_kind;
    for (const Array& array : bundle.arrays)  // lent: as large as they like
        file.arrays.arrays.push_back(
            {array.name, array.dtype, array.shape, Bytes::lent(array.bytes.data(), array.bytes.size())});
    write_described(path, file);
}

Bundle read_bundle(const std::string& path) { return read_described(path, {no_kind}).arrays; }

}  // namespace plumb::io
