// Colours that tell runs, wheels and sinkages apart, readable on light and dark ground.

export const runColours = ['#2f6fdf', '#e0701a', '#1f9d66', '#9a4fd0', '#cf3552', '#1697ab'];
export const wheelColours = ['#2f6fdf', '#e0701a', '#1f9d66', '#9a4fd0', '#cf3552', '#1697ab', '#9a8412', '#70757d'];

/** Sinkage from none to the greatest: sequential in lightness, far from the colour of soil. */
export const rutRamp = ['#bfe6e0', '#58b6cf', '#2a78bd', '#2c3f97', '#2a1259'];
/** Height of the ground, low to high. */
export const soilRamp = ['#7d6850', '#b19871', '#dfcda6'];

export const gradient = (ramp: string[]): string => `linear-gradient(to right, ${ramp.join(', ')})`;
