"""The user's own scene out of a glTF 2.0 file (.glb or .gltf): meshes, materials, lamps and named places."""
