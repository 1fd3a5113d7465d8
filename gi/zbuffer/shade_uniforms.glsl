// What the stages that shade ask of their blocks: ShadeUniforms of shade_kernel.h.

struct ShadeUniforms {
    int lights;
    int diffuse;    // 1: N . L counts
    int specular;   // 1: the lobe does
    int blinn;      // 1: of the half vector, 0: of the mirrored one
    int published;  // 1: as the listings have it
    int saturated;  // 1: colours end at 1
    int materials;
    int objects;
    vec4 ambient;   // xyz: irradiance that is there without a lamp, W/m2
    vec4 eye;       // xyz m
};
