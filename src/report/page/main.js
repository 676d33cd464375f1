document.body.append(tip);
document.querySelectorAll('table[data-csv]').forEach(addTools);
const block = document.getElementById('data');
const data = block ? JSON.parse(block.textContent) : { jobs: [] };
const jobs = [...document.querySelectorAll('[data-job]')]
  .map((section) => new JobView(section, data.jobs[Number(section.dataset.job)], data.surfaces));
document.documentElement.dataset.ready = '';
window.detune = {
  data, jobs, tipResponses, tipMotions,
  tcp: (arm, place) => ofTip(arm, placed(arm, place.joints_rad), place.tool_m),
};
