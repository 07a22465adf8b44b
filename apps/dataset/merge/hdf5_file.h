#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace aula {

/// An HDF5 file that is written. Equal calls give equal bytes: no times are stored. All functions
/// throw Failure if writing fails.
class Hdf5File {
 public:
    enum class Type { float32, float64, int64, text };
    using Id = std::int64_t;

    /// Creates a file; an existing one is replaced. Links and attributes keep the order of their
    /// creation, as netCDF-4 requires. `named`: the file in messages (MergedFolder).
    Hdf5File(const std::filesystem::path& file, std::filesystem::path named);
    ~Hdf5File();
    Hdf5File(const Hdf5File&) = delete;
    Hdf5File& operator=(const Hdf5File&) = delete;

    /// The root, for attributes.
    Id root() const { return file_id_; }

    /// Adds an attribute of text. HDF5 cannot store empty ones: an empty text becomes a space.
    void attribute(Id object, const std::string& name, const std::string& text);

    /// Creates a dataset whose rows are written separately. `size` has at least one element; all
    /// are at least 1.
    Id create(const std::string& name, Type type, const std::vector<std::uint64_t>& size);

    /// Creates a dimension of netCDF-4 without a variable.
    Id dimension(const std::string& name, std::uint64_t size);

    /// Names the dimensions of a dataset.
    void attach(Id dataset, const std::vector<Id>& dimensions);

    // Write one row, which is the part of a dataset with one index of its first dimension. `values`
    // has all its elements.
    void write_row(Id dataset, std::uint64_t row, const std::vector<float>& values);
    void write_row(Id dataset, std::uint64_t row, const std::vector<double>& values);
    void write_row(Id dataset, std::uint64_t row, std::int64_t value);
    void write_row(Id dataset, std::uint64_t row, const std::string& text);

    /// Completes the file. Nothing may be written afterwards.
    void close();

 private:
    void check(std::int64_t result) const;
    void write(Id dataset, std::uint64_t row, std::int64_t memory_type, const void* data);

    std::filesystem::path named_;
    Id file_id_ = -1;
    std::vector<Id> datasets_;
};

}  // namespace aula
