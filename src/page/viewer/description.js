// The description of the site, a script of its own.
(() => {
  "use strict";

  quadratura.describe = (site) => { quadratura.site = site; };

  quadratura.loadSite = async () => {
    await quadratura.script("site");
    if (!quadratura.site) throw new Error("data/site.js is damaged");
    if (quadratura.site.version !== 2) throw new Error("the data are of another version than the viewer");
    return quadratura.site;
  };
})();
