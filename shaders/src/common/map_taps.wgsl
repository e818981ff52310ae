// How many texels of a map are compared along a side for one point. A program writes this module anew for another number.
const TAPS: i32 = 3;
