#version 330 core
// World position to clip space; pyrender binds attribute 0 to positions and INST_M_LOC to the instance matrix.
layout(location = 0) in vec3 position;
layout(location = INST_M_LOC) in mat4 inst_m;
uniform mat4 M;
uniform mat4 V;
uniform mat4 P;
out vec3 world_position;

void main()
{
    vec4 world = M * inst_m * vec4(position, 1.0);
    world_position = world.xyz;
    gl_Position = P * V * world;
}
