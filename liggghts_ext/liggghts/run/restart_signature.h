#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace millscale {

/// Return the CRC-32 of ISO 3309, as zlib does.
inline std::uint32_t crc32(const std::string& bytes)
{
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ (value & 1 ? 0xEDB88320u : 0u);
      made[i] = value;
    }
    return made;
  }();
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char c : bytes) crc = table[(crc ^ static_cast<unsigned char>(c)) & 255u] ^ (crc >> 8);
  return crc ^ 0xFFFFFFFFu;
}

/// Return whether a restart file ends like a complete one: with a chunk of each rank, an int that
/// counts the doubles behind it. The engine does not notice when a full disk loses a part of the
/// file. A missing part anywhere before the end of a chunk displaces the count.
inline bool ends_with_chunks(const std::string& file, const std::vector<int>& doubles)
{
  std::size_t end = file.size();
  for (auto count = doubles.rbegin(); count != doubles.rend(); ++count) {
    const std::size_t bytes = sizeof(int) + static_cast<std::size_t>(*count) * sizeof(double);
    if (end < bytes) return false;
    end -= bytes;
    int found = 0;
    std::memcpy(&found, file.data() + end, sizeof found);
    if (found != *count) return false;
  }
  return true;
}

}  // namespace millscale
