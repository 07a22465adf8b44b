#include "engine/scene/directivity_hdf5.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

namespace aula {

namespace {

using Verdict = DirectivityHeader::Verdict;

/// An object of HDF5; negative if it does not exist.
class Identifier {
 public:
    explicit Identifier(hid_t id) : id_(id) {}
    ~Identifier() {
        if (id_ >= 0) H5Idec_ref(id_);
    }
    Identifier(const Identifier&) = delete;
    Identifier& operator=(const Identifier&) = delete;

    hid_t get() const { return id_; }
    bool exists() const { return id_ >= 0; }

 private:
    hid_t id_;
};

struct Variable {
    std::vector<hsize_t> sizes;
    std::vector<double> values;
    std::string type;  ///< the attribute Type
};

std::string text_attribute(const Identifier& object, const char* name) {
    constexpr std::size_t kLongest = 4096;  // bounds memory; names of conventions have below 100
    const Identifier attribute(H5Aopen(object.get(), name, H5P_DEFAULT));
    if (!attribute.exists()) return {};
    const Identifier space(H5Aget_space(attribute.get()));
    const Identifier type(H5Aget_type(attribute.get()));
    if (H5Sget_simple_extent_npoints(space.get()) != 1 || H5Tget_class(type.get()) != H5T_STRING)
        return {};
    if (H5Tis_variable_str(type.get()) > 0) {
        char* text = nullptr;
        if (H5Aread(attribute.get(), type.get(), &text) < 0 || text == nullptr) return {};
        std::string copy = text;
        H5free_memory(text);
        return copy;
    }
    const std::size_t size = H5Tget_size(type.get());
    if (size > kLongest) return {};
    std::string text(size, '\0');
    if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return {};
    return text.substr(0, text.find('\0'));
}

/// A numeric variable of 1 to 3 dimensions; empty if there is none of that name.
std::optional<Variable> variable(const Identifier& file, const char* name) {
    const Identifier set(H5Dopen2(file.get(), name, H5P_DEFAULT));
    if (!set.exists()) return std::nullopt;
    const Identifier space(H5Dget_space(set.get()));
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1 || rank > 3) return std::nullopt;
    Variable read;
    read.sizes.resize(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space.get(), read.sizes.data(), nullptr);
    hsize_t count = 1;
    for (const hsize_t size : read.sizes) {
        if (size == 0 || size > DirectivityHeader::kMaxValues) return std::nullopt;
        count *= size;
        if (count > DirectivityHeader::kMaxValues) return std::nullopt;
    }
    read.values.resize(count);
    if (H5Dread(set.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, read.values.data()) <
        0)
        return std::nullopt;
    read.type = text_attribute(set, "Type");
    return read;
}

/// The sizes of a variable; empty if there is none of that name.
std::vector<hsize_t> sizes_of(const Identifier& file, const char* name) {
    const Identifier set(H5Dopen2(file.get(), name, H5P_DEFAULT));
    if (!set.exists()) return {};
    const Identifier space(H5Dget_space(set.get()));
    hsize_t sizes[H5S_MAX_RANK];
    const int rank = H5Sget_simple_extent_dims(space.get(), sizes, nullptr);
    return rank < 0 ? std::vector<hsize_t>{} : std::vector<hsize_t>(sizes, sizes + rank);
}

/// Reads the first three numbers of an optional vector.
bool read_axis(const Identifier& file, const char* name, std::array<double, 3>& axis) {
    if (sizes_of(file, name).empty()) return true;
    const auto values = variable(file, name);
    if (!values || values->sizes.size() < 2 || values->sizes[1] != 3) return false;
    if (values->type == "spherical") return false;
    std::copy_n(values->values.begin(), 3, axis.begin());
    return true;
}

/// Opens a file in memory for reading, without a copy.
hid_t open_image(std::span<const std::byte> file) {
    if (file.empty()) return H5I_INVALID_HID;
    H5FD_file_image_callbacks_t uncopied{};
    uncopied.image_malloc = [](std::size_t, H5FD_file_image_op_t, void* image) { return image; };
    uncopied.image_memcpy = [](void* image, const void*, std::size_t, H5FD_file_image_op_t, void*) {
        return image;
    };
    uncopied.image_free = [](void*, H5FD_file_image_op_t, void*) { return herr_t{0}; };
    uncopied.udata_copy = [](void* image) { return image; };
    uncopied.udata_free = [](void*) { return herr_t{0}; };
    void* const image = const_cast<std::byte*>(file.data());  // never written: H5F_ACC_RDONLY
    uncopied.udata = image;
    const Identifier access(H5Pcreate(H5P_FILE_ACCESS));
    H5Pset_fapl_core(access.get(), 1, 0);
    H5Pset_file_image_callbacks(access.get(), &uncopied);
    H5Pset_file_image(access.get(), image, file.size());
    return H5Fopen("/file in memory", H5F_ACC_RDONLY, access.get());
}

DirectivityAnswer refusal(Verdict verdict) {
    DirectivityAnswer answer;
    answer.header.verdict = verdict;
    return answer;
}

}  // namespace

DirectivityAnswer read_hdf5_directivity(std::span<const std::byte> bytes) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    H5PLset_loading_state(0);
    const Identifier file(open_image(bytes));
    if (!file.exists()) return refusal(Verdict::unreadable);
    if (text_attribute(file, "SOFAConventions") != "FreeFieldDirectivityTF")
        return refusal(Verdict::other_kind);

    const std::vector<hsize_t> sizes = sizes_of(file, "Data.Real");
    if (sizes.size() != 3 || sizes != sizes_of(file, "Data.Imag"))
        return refusal(Verdict::incomplete);
    const auto [measurements, directions, frequencies] = std::array{sizes[0], sizes[1], sizes[2]};
    constexpr hsize_t kMax = DirectivityHeader::kMaxValues;
    if (directions > DirectivityHeader::kMaxDirections ||
        frequencies > DirectivityHeader::kMaxFrequencies || measurements > kMax ||
        measurements * directions > kMax || measurements * directions * frequencies > kMax)
        return refusal(Verdict::too_large);
    const auto real = variable(file, "Data.Real");
    const auto imaginary = variable(file, "Data.Imag");
    auto frequency = variable(file, "N");
    const auto position = variable(file, "ReceiverPosition");
    DirectivityAnswer answer;
    DirectivityHeader& header = answer.header;
    if (!real || !imaginary || !frequency || frequency->values.size() != frequencies || !position ||
        position->sizes.size() < 2 || position->sizes[0] != directions || position->sizes[1] != 3 ||
        !read_axis(file, "SourceView", header.view) || !read_axis(file, "SourceUp", header.up))
        return refusal(Verdict::incomplete);
    if (position->type != "spherical" && position->type != "cartesian")
        return refusal(Verdict::other_kind);

    // Coordinates and axes of the first measurement apply to all.
    const std::size_t stride = position->sizes.size() == 3 ? position->sizes[2] : 1;
    for (std::size_t i = 0; i < 3 * directions; ++i)
        answer.coordinates.push_back(position->values[i * stride]);
    answer.frequencies_hz = std::move(frequency->values);
    answer.energies.resize(directions * frequencies);
    for (std::size_t i = 0; i < real->values.size(); ++i) {
        const double re = real->values[i];
        const double im = imaginary->values[i];
        answer.energies[i % answer.energies.size()] += re * re + im * im;
    }
    header.verdict = Verdict::usable;
    header.directions = static_cast<std::uint32_t>(directions);
    header.frequencies = static_cast<std::uint32_t>(frequencies);
    header.spherical = position->type == "spherical" ? 1 : 0;
    return answer;
}

}  // namespace aula
