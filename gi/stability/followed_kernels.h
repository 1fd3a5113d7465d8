// Gives Followed (core/followed.h) what kernels that trace rays ask of a number type: rays go through the scene once, as
// float sends them, and what they met is on the tape for who follows. Only unbound_*.cpp include it, before the kernels.
#pragma once

#include "core/detmath_followed.h"
#include "core/followed.h"
#include "gi/trace_rays.h"

namespace plumb {

// Both numbers of a ray's hit are float's: same hits in double. Distance and barycentrics stand on the tape as given,
// so that they are moved as inputs are.
template <>
class RayTracer<Followed> {
  public:
    explicit RayTracer(const RayQuery& query) : tracer_(query) {}

    RayHit<Followed> nearest(const vec3<Followed>& origin, const vec3<Followed>& direction, bool active) {
        DecisionTape& tape = *followed_tape;
        if (tape.recording()) {
            const RayHit<float> hit = tracer_.nearest(value(origin), value(direction), active);
            tape.given_index.insert(tape.given_index.end(), {hit.found, hit.triangle});
            tape.given.insert(tape.given.end(), {hit.t, hit.barycentrics.x, hit.barycentrics.y});
        }
        const std::int32_t* index = tape.given_index.data() + at_index_;
        const float* number = tape.given.data() + at_;
        at_index_ += 2, at_ += 3;
        return {index[0] != 0, Followed(number[0]), index[1], {Followed(number[1]), Followed(number[2])}};
    }

    bool visible(const vec3<Followed>& origin, const vec3<Followed>& direction, const Followed& t_near,
                 const Followed& t_far, bool active) {
        DecisionTape& tape = *followed_tape;
        if (tape.recording())
            tape.given_index.push_back(
                tracer_.visible(value(origin), value(direction), t_near.value, t_far.value, active));
        return tape.given_index[at_index_++] != 0;
    }

    std::uint64_t traced() const { return tracer_.traced(); }

  private:
    static vec3<float> value(const vec3<Followed>& v) { return {v.x.value, v.y.value, v.z.value}; }

    RayTracer<float> tracer_;
    std::size_t at_ = 0, at_index_ = 0;
};

}  // namespace plumb
