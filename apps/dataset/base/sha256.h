#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace aula {

/// The hash SHA-256 (FIPS 180-4) of bytes that arrive in pieces.
class Sha256 {
 public:
    /// By the instructions of the processor for it, if it has them and they are not to be omitted.
    explicit Sha256(bool portable = false);

    void add(std::string_view bytes);

    /// The hash of all bytes as 64 hexadecimal digits. Nothing may be added afterwards.
    std::string hex();

 private:
    /// Adds whole blocks of 64 bytes.
    void compress(const unsigned char* bytes, std::size_t blocks);

    [[maybe_unused]] bool portable_;  ///< read where processors can have the instructions
    std::array<std::uint32_t, 8> state_;
    std::array<unsigned char, 64> block_{};
    std::size_t filled_ = 0;    ///< bytes of block_
    std::uint64_t length_ = 0;  ///< bytes that were added
};

/// The hash SHA-256 of bytes as 64 hexadecimal digits.
std::string sha256(std::string_view bytes);

/// Whether a text has the form of such a hash.
bool is_sha256(std::string_view text);

}  // namespace aula
