/* Noise that depends on seed, instance, channel and tick only: Philox 4x64-10 and Box-Muller.

   The streams equal those of numpy.random.Philox. Source: Salmon, Moraes, Dror, Shaw, Parallel
   random numbers: as easy as 1, 2, 3 (2011). */
#include "instance.h"

#include <math.h>

static const uint64_t MULTIPLIER_0 = 0xD2E7470EE14C6C93u, MULTIPLIER_1 = 0xCA5A826395121157u;
static const uint64_t WEYL_0 = 0x9E3779B97F4A7C15u, WEYL_1 = 0xBB67AE8584CAA73Bu;
static const double TWO_PI = 6.283185307179586;

static uint64_t multiply_high(uint64_t a, uint64_t b)
{
    const uint64_t a0 = a & 0xffffffffu, a1 = a >> 32, b0 = b & 0xffffffffu, b1 = b >> 32;
    const uint64_t middle = a1 * b0 + (a0 * b0 >> 32);
    const uint64_t other = a0 * b1 + (middle & 0xffffffffu);
    return a1 * b1 + (middle >> 32) + (other >> 32);
}

static void philox(uint64_t counter[4], uint64_t key0, uint64_t key1)
{
    for (int round = 0; round < 10; round++) {
        const uint64_t high0 = multiply_high(MULTIPLIER_0, counter[0]);
        const uint64_t high1 = multiply_high(MULTIPLIER_1, counter[2]);
        const uint64_t low0 = MULTIPLIER_0 * counter[0], low1 = MULTIPLIER_1 * counter[2];
        counter[0] = high1 ^ counter[1] ^ key0;
        counter[1] = low1;
        counter[2] = high0 ^ counter[3] ^ key1;
        counter[3] = low0;
        key0 += WEYL_0;
        key1 += WEYL_1;
    }
}

static void normal_pair(uint64_t a, uint64_t b, double pair[2])
{
    const double u1 = (double)((a >> 11) + 1) * 0x1p-53, u2 = (double)(b >> 11) * 0x1p-53;
    const double radius = sqrt(-2.0 * log(u1)), angle = TWO_PI * u2;
    pair[0] = radius * cos(angle);
    pair[1] = radius * sin(angle);
}

/* FNV-1a, 64 bit. */
uint64_t stream_of(const char *name)
{
    uint64_t hash = 0xCBF29CE484222325u;
    for (const unsigned char *byte = (const unsigned char *)name; *byte; byte++)
        hash = (hash ^ *byte) * 0x100000001B3u;
    return hash;
}

void draw_noise(Instance *self)
{
    const uint64_t seed = (uint64_t)self->s.v[SEED], tick = (uint64_t)self->s.tick;
    double *draws = self->s.noise;
    for (int channel = 0; channel < N_CHANNELS; channel++) {
        const int size = model_noise_sizes[channel];
        for (int first = 0; first < size; first += 4) {
            /* numpy counts up before it draws: its first block has the counter + 1 */
            uint64_t words[4] = {tick + 1, (uint64_t)channel, (uint64_t)(first / 4), 0};
            double four[4];
            philox(words, seed, self->s.stream);
            normal_pair(words[0], words[1], four);
            normal_pair(words[2], words[3], four + 2);
            for (int i = first; i < size && i < first + 4; i++)
                draws[i] = four[i - first];
        }
        draws += size;
    }
}
