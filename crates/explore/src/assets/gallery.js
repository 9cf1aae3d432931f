// The examples of the first screen: links to this page, each with a short description.

export const CASES = [
  {
    title: "The paper's section 5.1",
    words: "Where the first-order test promises a cycle that is not there: a band of width 2 ε γ² (1 − α) V to first order. Make ε small and it goes.",
    link: "#law=stribeck&x=gamma,0,8&y=c,0,6&show=difference:perturbation:simulation&p.epsilon=0.2&p.alpha=0.3&p.beta=0&p.V=1&p.gamma=4&p.c=2",
  },
  {
    title: "The missed double crossing",
    words: "Next to grazing the orbit is above the belt line for a moment only. A simulation with a stick band steps over it and denies the cycle.",
    link: "#law=stribeck&x=gamma,0,4&y=c,0,3&show=difference:stick_band:simulation&p.epsilon=0.0001&p.alpha=0.5&p.beta=0.2&p.V=1&p.gamma=2&p.c=0.1&pin=1",
  },
  {
    title: "The bistable band",
    words: "Between the Hopf and the grazing curve steady slip and stick-slip both attract. It depends on the last push which of them you see.",
    link: "#law=exponential&x=V,0.2,2.5&y=c,0,0.4&show=regime&p.epsilon=1&p.mu=0.5&p.vs=0.5&p.eta=0&p.V=1.5&p.c=0.1&pin=1",
  },
  {
    title: "A brake pad",
    words: "Friction falls from 0.4 to 0.25 over 5 cm/s. The pad groans at low speed of the disc unless damping stops it; all in SI units.",
    link: "#law=stribeck&motion=translation&x=belt_speed,0.01,0.4&y=damping,0,500&show=regime&p.mass=2&p.stiffness=505000&p.damping=60&p.normal_force=1000&p.static_friction=0.4&p.kinetic_friction=0.25&p.stribeck_velocity=0.05&p.strengthening=0&p.belt_speed=0.15&pin=1",
  },
  {
    title: "A drill string",
    words: "A bit on a long pipe turns in jerks. Turn faster, or damp it, until the blue region is left.",
    link: "#law=exponential&motion=rotation&x=belt_speed,0.5,20&y=damping,0,450&show=regime&p.mass=471.9698&p.stiffness=861.5336&p.damping=222.3067&p.normal_force=7778.75&p.static_friction=0.8&p.kinetic_friction=0.5&p.stribeck_velocity=1.111111111&p.strengthening=0&p.belt_speed=10&pin=1",
  },
  {
    title: "Leine's oscillator",
    words: "Friction 1/(1 + 3u) at belt speed 0.2 without damping: the period 12.00103 of the publication. Drag the point and watch the portrait.",
    link: "#law=stribeck&x=V,0.05,1&y=c,0,2&show=cycle_period&p.epsilon=1&p.alpha=0&p.beta=0&p.gamma=3&p.V=0.2&p.c=0&pin=1",
  },
  {
    title: "A law with several slip cycles",
    words: "A curve that wiggles makes cycles within cycles. Each fold of the backbone is where two of them meet and vanish.",
    link: "#law=expression&phi=1+-+0.3*u+%2B+0.12*(1-cos(6*u))/6+%2B+a*u^2&x=V,0.5,3&y=c,0,0.5&show=regime&p.epsilon=1&p.a=0.05&p.V=1.5&p.c=0.15&pin=1",
  },
  {
    title: "Fast belts",
    words: "Here the orbit may overshoot the stick segment. It crosses for ever, sticks, or spirals inward, in this order as the damping grows.",
    link: "#law=stribeck&x=V,5,60&y=c,0,0.06&show=regime&p.epsilon=1&p.alpha=0&p.beta=0&p.gamma=0.1&p.V=30&p.c=0.01&pin=1",
  },
  {
    title: "Which theorem decides",
    words: "Each colour is the weakest theorem that proves the answer. Where there are dots only the simulation has one.",
    link: "#law=stribeck&x=gamma,0,8&y=c,0,6&show=decider&p.epsilon=0.2&p.alpha=0.2&p.beta=0.1&p.V=1&p.gamma=3&p.c=1",
  },
];
