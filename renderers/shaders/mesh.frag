#version 330 core
// Triangle number and distance from the camera, in float: red = number + 1 (0 is the sky), green = metres.
uniform vec3 cam_pos;
in vec3 world_position;
layout(location = 0) out vec4 triangle_and_distance;

void main()
{
    triangle_and_distance = vec4(float(gl_PrimitiveID + 1), distance(cam_pos, world_position), 0.0, 1.0);
}
