// Compiled for x86-64-v2, v3 and v4; MILLSCALE_LEVEL is v2, v3 or v4. All functions here are local
// to the object file and call no library: one that object files share could be linked from this
// one, and would then run on a machine that lacks its instructions.
#include "core/neighbor/cells.h"
#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace millscale::neighbor::MILLSCALE_LEVEL {
namespace {

#ifdef __AVX2__
/// Return a mask of the first `count` of at most eight lanes; of none if `count` is negative.
inline unsigned low_bits(int count)
{
  return _bzhi_u32(0xff, count < 0 ? 0 : count < 8 ? count : 8);
}
#endif

#ifdef __AVX512VL__

/// Examines eight candidates at a time.
struct Search {
  static constexpr int width = 8, together = 16;
  __m512d x, y, z, reach;

  explicit Search(Centre centre)
      : x(_mm512_set1_pd(centre.x)),
        y(_mm512_set1_pd(centre.y)),
        z(_mm512_set1_pd(centre.z)),
        reach(_mm512_set1_pd(centre.reach))
  {
  }

  /// Write the partners among the first `count` candidates from k on, if any; return the end.
  int* operator()(const Candidates& of, int k, int count, int* out) const
  {
    const __m512d dx = x - _mm512_loadu_pd(of.x + k), dy = y - _mm512_loadu_pd(of.y + k);
    const __m512d dz = z - _mm512_loadu_pd(of.z + k);
    const __m512d both = reach + _mm512_loadu_pd(of.reach + k);
    const unsigned near =
        _mm512_cmp_pd_mask(both * both, dx * dx + dy * dy + dz * dz, _CMP_GT_OQ) & low_bits(count);
    const __m256i index = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(of.index + k));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                        _mm256_maskz_compress_epi32(static_cast<__mmask8>(near), index));
    return out + __builtin_popcount(near);
  }
};

#elif defined __AVX2__

/// For each combination of four bits, the lanes of its bits in ascending order.
struct Orders {
  alignas(16) int of[16][4];
};
constexpr Orders make_orders()
{
  Orders orders{};
  for (int bits = 0; bits < 16; ++bits)
    for (int lane = 0, rank = 0; lane < 4; ++lane)
      if (bits >> lane & 1) orders.of[bits][rank++] = lane;
  return orders;
}
constexpr Orders orders = make_orders();

/// Examines four candidates at a time.
struct Search {
  static constexpr int width = 4, together = 16;
  __m256d x, y, z, reach;

  explicit Search(Centre centre)
      : x(_mm256_set1_pd(centre.x)),
        y(_mm256_set1_pd(centre.y)),
        z(_mm256_set1_pd(centre.z)),
        reach(_mm256_set1_pd(centre.reach))
  {
  }

  /// Write the partners among the first `count` candidates from k on, if any; return the end.
  int* operator()(const Candidates& of, int k, int count, int* out) const
  {
    const __m256d dx = x - _mm256_loadu_pd(of.x + k), dy = y - _mm256_loadu_pd(of.y + k);
    const __m256d dz = z - _mm256_loadu_pd(of.z + k);
    const __m256d both = reach + _mm256_loadu_pd(of.reach + k);
    const int near =
        _mm256_movemask_pd(_mm256_cmp_pd(both * both, dx * dx + dy * dy + dz * dz, _CMP_GT_OQ)) &
        low_bits(count);
    const __m128 index = _mm_loadu_ps(reinterpret_cast<const float*>(of.index + k));
    _mm_storeu_ps(reinterpret_cast<float*>(out),
                  _mm_permutevar_ps(
                      index, _mm_load_si128(reinterpret_cast<const __m128i*>(orders.of[near]))));
    return out + __builtin_popcount(near);
  }
};

#else

/// Examines one candidate at a time.
struct Search {
  static constexpr int width = 1, together = 1;
  Centre centre;

  explicit Search(Centre c) : centre(c) {}

  int* operator()(const Candidates& of, int k, int count, int* out) const
  {
    if (count <= 0) return out;
    const double x = centre.x - of.x[k], y = centre.y - of.y[k], z = centre.z - of.z[k];
    const double both = centre.reach + of.reach[k];
    *out = of.index[k];  // kept only if it counts: no branch to mispredict
    return out + (x * x + y * y + z * z < both * both);
  }
};

#endif

}  // namespace

int* list_partners(const Candidates& candidates, Centre centre, int* out)
{
  const Search search(centre);
  for (int s = 0; s < candidates.count; ++s) {
    const Span span = candidates.spans[s];
    int k = span.first;
    do {  // most spans hold 0 to 16: with the same turn for all of them no branch is mispredicted
      for (int part = 0; part < Search::together; part += Search::width, k += Search::width)
        out = search(candidates, k, span.end - k, out);
    } while (k < span.end);
  }
  return out;
}

}  // namespace millscale::neighbor::MILLSCALE_LEVEL
