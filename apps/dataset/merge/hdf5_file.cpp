#include "apps/dataset/merge/hdf5_file.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

#include "apps/output/formatted.h"
#include "aula/exception.h"

namespace aula {

namespace {

/// An object of HDF5 that is closed at the end of its scope.
class Scoped {
 public:
    Scoped(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Scoped() {
        if (id_ >= 0) close_(id_);
    }
    Scoped(const Scoped&) = delete;
    Scoped& operator=(const Scoped&) = delete;
    operator hid_t() const { return id_; }

 private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

hid_t text_type() {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

hid_t copy_of(Hdf5File::Type type) {
    switch (type) {
        case Hdf5File::Type::float32:
            return H5Tcopy(H5T_IEEE_F32LE);
        case Hdf5File::Type::float64:
            return H5Tcopy(H5T_IEEE_F64LE);
        case Hdf5File::Type::int64:
            return H5Tcopy(H5T_STD_I64LE);
        case Hdf5File::Type::text:
            break;
    }
    return text_type();
}

/// The operating system's reason in the stack of errors of the last call, which HDF5 gives as text
/// only: "file write failed: ..., errno = 28, error message = 'No space left on device', ...".
/// Without one, the description of the first error.
std::string last_error() {
    std::string description;
    const auto read = [](unsigned position, const H5E_error2_t* error, void* result) -> herr_t {
        if (position == 0 && error->desc != nullptr)
            *static_cast<std::string*>(result) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, read, &description);
    constexpr std::string_view kNumber = "errno = ";
    const std::size_t at = description.find(kNumber);
    if (at == std::string::npos) return description;
    const char* const number = description.c_str() + at + kNumber.size();
    return std::generic_category().message(static_cast<int>(std::strtol(number, nullptr, 10)));
}

constexpr unsigned kOrder = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
/// Rows of small datasets are stored together.
constexpr std::uint64_t kChunkElements = 4096;

}  // namespace

void Hdf5File::check(std::int64_t result) const {
    if (result < 0)
        throw Failure(named_.string() + ": cannot write the HDF5 file: " + last_error());
}

Hdf5File::Hdf5File(const std::filesystem::path& file, std::filesystem::path named)
    : named_(std::move(named)) {
    // After a failed write, as on a full disk, HDF5 would close the file again at the program's end
    // and crash.
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // no messages on standard error
    const Scoped order(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_link_creation_order(order, kOrder);
    H5Pset_attr_creation_order(order, kOrder);
    H5Pset_obj_track_times(order, 0);
    file_id_ = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, order, H5P_DEFAULT);
    check(file_id_);
}

Hdf5File::~Hdf5File() {
    for (const Id id : datasets_) H5Dclose(id);
    if (file_id_ >= 0) H5Fclose(file_id_);
}

void Hdf5File::attribute(Id object, const std::string& name, const std::string& text) {
    const std::string stored = text.empty() ? " " : text;
    const Scoped type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, stored.size());
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    const bool ascii = std::all_of(stored.begin(), stored.end(),
                                   [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    if (!ascii) H5Tset_cset(type, H5T_CSET_UTF8);
    const Scoped space(H5Screate(H5S_SCALAR), H5Sclose);
    const Scoped attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose);
    check(attribute);
    check(H5Awrite(attribute, type, stored.data()));
}

Hdf5File::Id Hdf5File::create(const std::string& name, Type type,
                              const std::vector<std::uint64_t>& size) {
    std::vector<hsize_t> chunk(size.begin(), size.end());
    std::uint64_t row = 1;
    for (std::size_t d = 1; d < size.size(); ++d) row *= size[d];
    chunk[0] = std::clamp<std::uint64_t>(kChunkElements / row, 1, size[0]);
    const Scoped settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(settings, 0);
    H5Pset_attr_creation_order(settings, kOrder);
    H5Pset_chunk(settings, static_cast<int>(chunk.size()), chunk.data());
    const std::vector<hsize_t> sizes(size.begin(), size.end());
    const Scoped space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr),
                       H5Sclose);
    const Scoped stored(copy_of(type), H5Tclose);
    const Id dataset =
        H5Dcreate2(file_id_, name.c_str(), stored, space, H5P_DEFAULT, settings, H5P_DEFAULT);
    check(dataset);
    datasets_.push_back(dataset);
    return dataset;
}

Hdf5File::Id Hdf5File::dimension(const std::string& name, std::uint64_t size) {
    const Scoped settings(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(settings, 0);
    H5Pset_attr_creation_order(settings, kOrder);
    const hsize_t count = size;
    const Scoped space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Id dataset = H5Dcreate2(file_id_, name.c_str(), H5T_IEEE_F32BE, space, H5P_DEFAULT,
                                  settings, H5P_DEFAULT);
    check(dataset);
    datasets_.push_back(dataset);
    // The name by which netCDF-4 recognises a dimension without a variable.
    check(H5DSset_scale(dataset,
                        formatted("This is a netCDF dimension but not a netCDF variable. %10llu",
                                  static_cast<unsigned long long>(size))
                            .c_str()));
    return dataset;
}

void Hdf5File::attach(Id dataset, const std::vector<Id>& dimensions) {
    for (std::size_t d = 0; d < dimensions.size(); ++d)
        check(H5DSattach_scale(dataset, dimensions[d], static_cast<unsigned>(d)));
}

void Hdf5File::write(Id dataset, std::uint64_t row, std::int64_t memory_type, const void* data) {
    const Scoped space(H5Dget_space(dataset), H5Sclose);
    std::vector<hsize_t> count(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    check(H5Sget_simple_extent_dims(space, count.data(), nullptr));
    std::vector<hsize_t> start(count.size(), 0);
    start[0] = row;
    count[0] = 1;
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
    const Scoped memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                        H5Sclose);
    check(H5Dwrite(dataset, memory_type, memory, space, H5P_DEFAULT, data));
}

void Hdf5File::write_row(Id dataset, std::uint64_t row, const std::vector<float>& values) {
    write(dataset, row, H5T_NATIVE_FLOAT, values.data());
}

void Hdf5File::write_row(Id dataset, std::uint64_t row, const std::vector<double>& values) {
    write(dataset, row, H5T_NATIVE_DOUBLE, values.data());
}

void Hdf5File::write_row(Id dataset, std::uint64_t row, std::int64_t value) {
    write(dataset, row, H5T_NATIVE_INT64, &value);
}

void Hdf5File::write_row(Id dataset, std::uint64_t row, const std::string& text) {
    const Scoped type(text_type(), H5Tclose);
    const char* const data = text.c_str();
    write(dataset, row, type, &data);
}

void Hdf5File::close() {
    for (const Id id : std::exchange(datasets_, {})) check(H5Dclose(id));
    check(H5Fclose(std::exchange(file_id_, -1)));
}

}  // namespace aula
