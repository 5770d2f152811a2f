"""What there is to see: scenes, surfaces, materials, lights, landmarks, tours. Imports no other room."""
